"""What is learned: networks that take one sequence, one element."""

from motorspace.models.config import ModelConfig as ModelConfig
from motorspace.models.encoder import AbstractMotorEncoder as AbstractMotorEncoder
from motorspace.models.model import InverseModel as InverseModel
from motorspace.models.model import Model as Model
from motorspace.models.model import Scaling as Scaling
from motorspace.models.model import SensorPredictor as SensorPredictor
from motorspace.models.model import build_model as build_model
