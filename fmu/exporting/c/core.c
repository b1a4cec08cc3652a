/* jounce's core, all of what plans and follows, in the one file that is compiled. */

#include "scaling.c"
#include "pieces.c"
#include "velocity_change.c"
#include "inside.c"
#include "speed_profiles.c"
#include "jerk_profiles.c"
#include "families.c"
#include "transfer.c"
#include "follower.c"
#include "lags.c"
