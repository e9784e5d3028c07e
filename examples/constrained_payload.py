"""A payload that can exist, with what is known beforehand: a scale, a box for the centre of mass, drive gains."""

from dynident import InertialParameters, Simulator, load_robot, payload_problem, random_via_points
from dynident.estimation import CentreOfMassInBox, Gains, KnownMass, Settings, answer_payload
from dynident.trajectories import RX90_NOISE

robot = load_robot("rx90")
body = InertialParameters.from_com(7.025, [0.0, 0.0, 0.143], [[0.018, 0, 0], [0, 0.018, 0], [0, 0, 0.035]])
simulator = Simulator(robot)
motion = random_via_points(robot, count=14, seed=1).motion(rate=250.0)
unloaded = [simulator.record(motion, None, RX90_NOISE, seed=[1, 0])]
loaded = [simulator.record(motion, body, RX90_NOISE, seed=[1, 1])]

settings = Settings(methods=(4,), gains=Gains(per_joint=[0.01], common=0.005))
problem = payload_problem(robot, loaded, unloaded, settings=settings)
known = [KnownMass(7.02, 0.01), CentreOfMassInBox([-0.02, -0.02, 0.05], [0.02, 0.02, 0.25])]

for title, constraints in (("nothing known", []), ("scale and drawing", known)):
    payload = answer_payload(problem, constraints=constraints).recommended
    low, high = payload.intervals.parameters[9]
    print(f"{title} (method {payload.method}):")
    print(f"  mass {payload.mass:.3f} kg, 95 % from {low:.3f} to {high:.3f}")
    for axis, value, (low, high) in zip("xyz", payload.body.com, payload.intervals.com, strict=True):
        print(f"  centre of mass {axis} {1e3 * value:6.1f} mm, from {1e3 * low:6.1f} to {1e3 * high:6.1f}")
    print(f"  principal moments {payload.principal_moments.round(4)} kg m²")
    print(f"  the constraints cost chi2 {payload.result.chi2_rise:.2f} (p {payload.result.p_value:.2f})")
    for active in payload.result.active:
        print(f"  held back by: {active.description}")

# A constraint that contradicts the data is named, not obeyed in silence.
wrong = answer_payload(problem, constraints=[KnownMass(5.0, 0.01)]).verdict
print(wrong.level, wrong.reasons[0])
