from rcss_hat.envs.keepaway_env import KeepawayEnv as KeepawayEnv
from rcss_hat.envs.vector import KeepawayVectorEnv as KeepawayVectorEnv
from rcss_hat.everyday import EndedEarly as EndedEarly
from rcss_hat.everyday import demonstrate as demonstrate
from rcss_hat.everyday import learn as learn
from rcss_hat.everyday import play as play
from rcss_hat.experiments.episode_log import read_episode_log as read_episode_log
from rcss_hat.experiments.metrics import learning_curve as learning_curve
from rcss_hat.experiments.run_folder import RunConfig as RunConfig
from rcss_hat.experiments.sets import package_demonstrations as package_demonstrations
from rcss_hat.experiments.training import TrainingRun as TrainingRun
from rcss_hat.hat.decision_list import DecisionList as DecisionList
from rcss_hat.hat.demonstrations import Demonstration as Demonstration
from rcss_hat.hat.demonstrations import DemonstrationSet as DemonstrationSet
from rcss_hat.hat.policy import load_policy as load_policy
from rcss_hat.hat.registry import METHODS as METHODS
from rcss_hat.hat.ripper import RipperClassifier as RipperClassifier
from rcss_hat.hat.summarize import summarize as summarize
from rcss_hat.hat.transfer.method import TransferMethod as TransferMethod
from rcss_hat.keepaway.report import RunReport as RunReport
from rcss_hat.keepaway.task import Task as Task
from rcss_hat.learning.config import LearnerConfig as LearnerConfig
from rcss_hat.learning.config import load_config as load_config
from rcss_hat.stage.place import Place as Place
from rcss_hat.stage.stages import Part as Part
from rcss_hat.stage.stages import open_stage as open_stage

__version__: str
