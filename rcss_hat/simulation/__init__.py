"""Match state, physics, perception and referee of rcssserver as compiled kernels; no text, no sockets.

A caller makes a match (``state.new_match``, ``state.connect``, ``keepaway.kick_off``) and then, cycle by cycle, gives
commands (``commands``), advances (``cycle.step``) and lets players sense (``body.sense_body``), hear
(``hearing.deliver`` or ``hearing.hear_teammate``) and see (``vision.see``) when ``clock`` says so. All kernels take the
MATCH record, the server's PARAMS, where needed the player types, and the match's random streams, which alone decide
what is random.

With the profile "11.1" of the parameters the kernels behave as server 11.1.2: dashes act at once and along the body,
failed kicks leave the command, noise is drawn per component, effort recovers from 30 % on, stamina is not restored
between episodes, teams are seen up to 60 m.

Not simulated: wind, ``team_actuator_noise``, substitutions by an online coach, and what ``referee`` names.
"""
