"""Systems to take responses of."""

import control

from jounce.shaping import Limits, min_time_move

MOVE = min_time_move(1.0, Limits(velocity=0.5, acceleration=1.0, jerk=4.0))
LAG = control.ss([[-1.0]], [[1.0]], [[1.0]], [[0.0]])
