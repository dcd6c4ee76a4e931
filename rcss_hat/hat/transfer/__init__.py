"""The transfer methods: how a summary of demonstrations biases learning.

>>> from rcss_hat.hat.transfer import PPR, Learners
>>> from rcss_hat.learning import load_config
>>> team = Learners.create(load_config("paper"), PPR(), n_keepers=3, n_takers=2, seed=1)
>>> team.method.describe()
'Probabilistic Policy Reuse: psi = 0.999 ** episodes'
"""

from rcss_hat.hat.registry import METHODS
from rcss_hat.hat.transfer.chat import CHAT
from rcss_hat.hat.transfer.extra_action import ExtraAction
from rcss_hat.hat.transfer.learners import KeeperLearner, Learners, warm_up
from rcss_hat.hat.transfer.making import make_method, parameters
from rcss_hat.hat.transfer.method import NO_ADVICE, TransferMethod
from rcss_hat.hat.transfer.no_prior import NoPrior
from rcss_hat.hat.transfer.ppr import PPR
from rcss_hat.hat.transfer.replay import Decisions, Replay
from rcss_hat.hat.transfer.value_bonus import ValueBonus

__all__ = [
    "CHAT",
    "METHODS",
    "NO_ADVICE",
    "Decisions",
    "ExtraAction",
    "KeeperLearner",
    "Learners",
    "NoPrior",
    "PPR",
    "Replay",
    "TransferMethod",
    "ValueBonus",
    "make_method",
    "parameters",
    "warm_up",
]
