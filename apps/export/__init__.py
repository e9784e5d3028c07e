"""Results in the form of controllers and simulators, and motions in the form of controllers."""
