"""Function approximators, Sarsa and exploration, compiled."""

from rcss_hat.learning.checkpoint import Checkpoint, CheckpointError, load_checkpoint, save_checkpoint
from rcss_hat.learning.config import LearnerConfig, load_config, preset_names
from rcss_hat.learning.features import Approximator, cmac, rbf

__all__ = [
    "Approximator",
    "Checkpoint",
    "CheckpointError",
    "LearnerConfig",
    "cmac",
    "load_checkpoint",
    "load_config",
    "preset_names",
    "rbf",
    "save_checkpoint",
]
