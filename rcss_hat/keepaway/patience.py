"""How long a player waits for the server before it acts without a word of it, and what it bears with."""

from __future__ import annotations

WAIT_FOR_SEE, ON_THE_WAY = 0.75, 0.008
"""Part of a real-time cycle after which a player no longer waits for a see message; seconds of the cycle that must be
left then for the commands to come in time, but not more than half of it."""
OVERDUE, SILENT = 0.1, 0.4
"""Synch mode on a troubled network: seconds from a sense_body after which a player answers without ``(think)`` when an
odd one came before, and seconds of silence after which it answers in any case, or says ``(done)`` again. A server waits
1.25 s for an answer; delays of 150 ms either way are no reason for another one."""
OVERTAKEN = 100
"""Cycles by which a message may be late; one that is older tells that the server's clock was set back."""
KEPT, KEPT_BYTES = 8, 200
"""How many messages that a player does not know are kept, and how much of each."""
