/* Samples at start, start + SAMPLE_TIME, ...: counted, so that none is lost or run twice.
 *
 * Sample k runs in the step that starts at its time or holds it; hosts that add up t += h are
 * off by rounding, so a hundredth of a sample (a quarter of a shorter step) counts as equal.
 */

#define MOST_TICKS 1e9

static double tick_slack(double h) {
    return smaller(0.01 * SAMPLE_TIME, 0.25 * h);
}

static double tick_time(const State *s, int64_t tick) {
    return s->start + (double)tick * SAMPLE_TIME;
}

/* Returns what went wrong, or NULL. */
static const char *core_tick(State *s, Cache *cache);

static const char *run_ticks(State *s, Cache *cache, double end, double h) {
    if ((end - tick_time(s, s->ticks)) / SAMPLE_TIME > MOST_TICKS) {
        return "the step holds more than 1e9 samples: use a shorter one";
    }
    while (tick_time(s, s->ticks) < end - tick_slack(h)) {
        const char *problem = core_tick(s, cache);
        if (problem) {
            return problem;
        }
        s->ticks += 1;
    }
    return NULL;
}
