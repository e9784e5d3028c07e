from .stored import StoredGains as StoredGains
from .stored import StoredRobot as StoredRobot
from .stored import read_information as read_information
from .stored import read_stored_gains as read_stored_gains
from .stored import read_stored_robot as read_stored_robot
from .stored import recorded_noise as recorded_noise
from .stored_payload import StoredPayload as StoredPayload
from .stored_payload import read_stored_payload as read_stored_payload
