/* A pure inertia under a torque that is held during the step: exact. */

static void core_initialize(State *s) {
    (void)s;
}

static void core_outputs(State *s, int running) {
    (void)running;
    s->value[V_DER_Y] = s->value[V_Y_RATE];
    s->value[V_DER_Y_RATE] = s->value[V_U] / s->value[V_J];
}

static const char *core_step(State *s, Cache *cache, double t, double h) {
    double acceleration = s->value[V_U] / s->value[V_J];
    (void)cache, (void)t;
    s->value[V_Y] += h * (s->value[V_Y_RATE] + 0.5 * h * acceleration);
    s->value[V_Y_RATE] += h * acceleration;
    return NULL;
}

#if defined(HAS_PARTIALS)
static double core_partial(const State *s, int unknown, int known) {
    if (unknown == V_DER_Y_RATE) {
        return known == V_U ? 1.0 / s->value[V_J] : 0.0;
    }
    return known == (unknown == V_DER_Y ? V_Y_RATE : unknown) ? 1.0 : 0.0;
}
#endif
