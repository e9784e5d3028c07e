"""Motions predicted from measured torques by a robot's parameters, compared with what was measured."""
