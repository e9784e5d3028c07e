"""From recordings to parameters. Imports only the model room."""

from .alignment import AlignedPair, aligned
from .bounding import InEllipsoid, InHull
from .cone import SolverError
from .conflicts import Tested, Weighing
from .constrained import ConstrainedEstimate, CvxpyProblem, build_constrained, solve_constrained
from .constrained_base import ConstrainedBase, Holding, solve_constrained_base
from .constrained_prior import ConstrainedRobot, solve_constrained_prior
from .constraints import CentreOfMassInBox, Constraint, KnownMass, MassBounds, PossibleBody
from .decimation import decimated, noise_bandwidth
from .drive_gains import GainErrors
from .essential import Elimination, EliminationPath, SigmaBound, SigmaRatio, StopRule, eliminate
from .estimate import Estimate, Fit, fit
from .excitation import Excitation, excitation, payload_excitation
from .filtering import measurement, resampled
from .gains import DriveGains, GainProblem, gain_problem, identify_gains
from .identification import Identification, base_problem, identify
from .impossible import elimination_warnings, impossible_payload, impossible_robot
from .information import Information, read_information, recorded_noise
from .intervals import Intervals, profile_intervals
from .kinematics_check import KinematicsCheck, Ranked, rank_readings, rank_readings_by_pose
from .least_squares import ordinary, weighted
from .link_origins import LinkOrigins, RobotOrigins, robot_origins
from .logs import LogMap, TrajectoryTable, read_log_map, read_recording, read_trajectory, stream_samples
from .long_logs import reduced_log
from .names import PAYLOAD
from .observation import Observation, Observer
from .origins import Gauge, Origin, hidden_directions, origins
from .payload import (
    ByJoints,
    ConstrainedPayload,
    JointShare,
    JointsMass,
    PairedMeasurement,
    PayloadAnswer,
    PayloadBlocks,
    PayloadEstimate,
    PayloadProblem,
    Stretch,
    answer_payload,
    combined,
    constrain_payload,
    difference_problem,
    essential_combined,
    identify_payload,
    loaded_problem,
    payload_blocks,
    payload_by_joints,
    payload_over_time,
    payload_problem,
    usable_methods,
)
from .pose_check import PoseCheck, check_pose
from .prediction import Curve, TorquePrediction, payload_prediction, payload_predictions, robot_prediction
from .problem import ReducedProblem, merged
from .readings import Reading
from .reduction import reduced, reduced_measurement, reduced_stream
from .robot_prior import RobotPrior, cylinder_prior, robot_prior
from .robust import RobustCovariance, jackknife
from .scaling import Active
from .system import ObservationSystem, identification_system, payload_system
from .verdict import Verdict
from .weigh import (
    OFFSET_SHARE,
    RIPPLE_CHANCE,
    Agreement,
    Change,
    Following,
    FollowingChange,
    Judged,
    Repeats,
    StandIn,
    WeighAnswer,
    WeighEstimate,
    WeighProblem,
    answer_weighing,
    difference_weighing,
    following_change,
    known_robot_weighing,
    read_following,
    solve_weighing,
    weigh_by_joints,
)

__all__ = [
    "OFFSET_SHARE",
    "PAYLOAD",
    "RIPPLE_CHANCE",
    "Active",
    "Agreement",
    "AlignedPair",
    "ByJoints",
    "CentreOfMassInBox",
    "Change",
    "ConstrainedBase",
    "ConstrainedEstimate",
    "ConstrainedPayload",
    "ConstrainedRobot",
    "Constraint",
    "Curve",
    "CvxpyProblem",
    "DriveGains",
    "Elimination",
    "EliminationPath",
    "Estimate",
    "Excitation",
    "Fit",
    "Following",
    "FollowingChange",
    "GainErrors",
    "GainProblem",
    "Gauge",
    "Holding",
    "Identification",
    "InEllipsoid",
    "InHull",
    "Information",
    "Intervals",
    "JointShare",
    "JointsMass",
    "Judged",
    "KinematicsCheck",
    "KnownMass",
    "LinkOrigins",
    "LogMap",
    "MassBounds",
    "Observation",
    "ObservationSystem",
    "Observer",
    "Origin",
    "PairedMeasurement",
    "PayloadAnswer",
    "PayloadBlocks",
    "PayloadEstimate",
    "PayloadProblem",
    "PoseCheck",
    "PossibleBody",
    "Ranked",
    "Reading",
    "ReducedProblem",
    "Repeats",
    "RobotOrigins",
    "RobotPrior",
    "RobustCovariance",
    "SigmaBound",
    "SigmaRatio",
    "SolverError",
    "StandIn",
    "StopRule",
    "Stretch",
    "Tested",
    "TorquePrediction",
    "TrajectoryTable",
    "Verdict",
    "WeighAnswer",
    "WeighEstimate",
    "WeighProblem",
    "Weighing",
    "aligned",
    "answer_payload",
    "answer_weighing",
    "base_problem",
    "build_constrained",
    "check_pose",
    "combined",
    "constrain_payload",
    "cylinder_prior",
    "decimated",
    "difference_problem",
    "difference_weighing",
    "eliminate",
    "elimination_warnings",
    "essential_combined",
    "excitation",
    "fit",
    "following_change",
    "gain_problem",
    "hidden_directions",
    "identification_system",
    "identify",
    "identify_gains",
    "identify_payload",
    "impossible_payload",
    "impossible_robot",
    "jackknife",
    "known_robot_weighing",
    "loaded_problem",
    "measurement",
    "merged",
    "noise_bandwidth",
    "ordinary",
    "origins",
    "payload_blocks",
    "payload_by_joints",
    "payload_excitation",
    "payload_over_time",
    "payload_prediction",
    "payload_predictions",
    "payload_problem",
    "payload_system",
    "profile_intervals",
    "rank_readings",
    "rank_readings_by_pose",
    "read_following",
    "read_information",
    "read_log_map",
    "read_recording",
    "read_trajectory",
    "recorded_noise",
    "reduced",
    "reduced_log",
    "reduced_measurement",
    "reduced_stream",
    "resampled",
    "robot_origins",
    "robot_prediction",
    "robot_prior",
    "solve_constrained",
    "solve_constrained_base",
    "solve_constrained_prior",
    "solve_weighing",
    "stream_samples",
    "usable_methods",
    "weigh_by_joints",
    "weighted",
]
