"""Options that several commands have, and what is to be added for each to count; see ``options``."""

ROBOT = {
    "--robot": "--robot tx40",
    "--chain": "--chain link_1:link_2",
    "--mount": "--mount wall",
}
STAND_IN = {"--arm-mass": "--arm-mass 20"}
LOGS = {
    "--log-map": "--log-map turned.toml",
    "--joints": "--joints a,b,c,d,e,f",
    "--units": "--units q=deg",
    "--signs": "--signs=1,-1,1,1,1,1",
    "--topic": "--topic /joint_states",
}
PROCESSING = {
    "--rate": "--rate 90",
    "--cutoff": "--cutoff 4",
    "--equation-rate": "--equation-rate 15",
    "--offsets": "--offsets false | --offsets true",
    "--coulomb": "--coulomb paper",
}
FILTER = {option: entry for option, entry in PROCESSING.items() if option != "--equation-rate"}
KNOWN = {
    "--mass": "--mass 6.2+-0.05 | --mass 6.2+-0.5",
    "--mass-bounds": "--mass-bounds 6.5,",
    "--com-within": "--com-within=0.02,0.03,0,0.01,0.1,0.2",
    "--ellipsoid": "--ellipsoid=0,0,0.1,0.1,0.1,0.1",
}
LINKS = {name: ROBOT[name] for name in ("--robot", "--chain")}
GAINS = {"--gain-sigma": "--gain-sigma 2% | --gain-sigma 2%,common=1%"}
STOPS = {"--essential": "--essential 1.2"}
EQUATIONS = {"--json": "--json a.json", "--npz": "--npz a.npz"}
PAGE = {"--report": "--report a.html", "--plots": "--plots figures"}
VIEW = {"--view": "--view a.html"}
LIMITS = {
    "--speed-override": "--speed-override 0.5",
    "--acceleration": "--acceleration 2x",
    "--torque-limits": "--torque-limits 300,300,120,50,40,20",
    "--robot-parameters": "--robot-parameters tx_robot.json",
    "--scene": "--scene scene.toml",
    "--heaviest-payload": "--heaviest-payload 7@0,0,0.2",
    "--within": "--heaviest-payload 2@0,0,0.1 | --within 0.1",
    "--torque-margin": "--torque-margin 5%",
}
MOTIONS = {
    "--json": "--json a.json",
    "--samples": "--samples a.csv",
    "--ros2": "--ros2 a.yaml",
    "--joint-names": "--ros2 a.yaml | --joint-names a,b,c,d,e,f",
    "--urscript": "--urscript a.script",
    "--controller-rate": "--urscript a.script | --controller-rate 125",
    "--sample-rate": "--samples a.csv | --sample-rate 125",
}
CURRENTS = {"--drive-gains": "--drive-gains 1,2,3,4,5,6"}
HOST = {"--host": "--host 127.0.0.1.1", "--port": "--port 1"}
