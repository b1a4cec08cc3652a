/* Snapshots of an instance, and their serialised form: a header, then the state. */

typedef struct {
    char magic[40]; /* begins with the token, so that no other FMU takes it */
    uint64_t size, checksum;
} Header;

#define SNAPSHOT_SIZE (sizeof(Header) + sizeof(State))

static void copy_bytes(void *to, const void *from, size_t size) {
    size_t i;
    for (i = 0; i < size; i++) {
        ((unsigned char *)to)[i] = ((const unsigned char *)from)[i];
    }
}

static uint64_t checksum(const State *state) { /* FNV-1a */
    const unsigned char *bytes = (const unsigned char *)state;
    uint64_t sum = 14695981039346656037u;
    size_t i;
    for (i = 0; i < sizeof *state; i++) {
        sum = (sum ^ bytes[i]) * 1099511628211u;
    }
    return sum;
}

static Header header_of(const State *state) {
    Header header = {{0}, sizeof(State), 0};
    int i;
    for (i = 0; i < 39 && TOKEN[i]; i++) {
        header.magic[i] = TOKEN[i];
    }
    header.checksum = checksum(state);
    return header;
}

static int serialize(Instance *it, const State *state, unsigned char *bytes, size_t size) {
    Header header;
    if (!state || !bytes || size != SNAPSHOT_SIZE) {
        return fail_with(it, "size", (double)size, ": expected that of a serialised state, ",
                         (double)SNAPSHOT_SIZE);
    }
    header = header_of(state);
    copy_bytes(bytes, &header, sizeof header);
    copy_bytes(bytes + sizeof header, state, sizeof *state);
    return OK;
}

static int deserialize(Instance *it, const unsigned char *bytes, size_t size, State *state) {
    Header found, expected = header_of(state);
    size_t i;
    if (bytes && size >= sizeof found) {
        copy_bytes(&found, bytes, sizeof found);
        for (i = 0; i < sizeof found.magic; i++) {
            if (found.magic[i] != expected.magic[i]) {
                return fail(it, "the serialised state is not of this FMU");
            }
        }
    }
    if (!bytes || size != SNAPSHOT_SIZE) {
        return fail_with(it, "size", (double)size, ": expected a serialised state of ",
                         (double)SNAPSHOT_SIZE);
    }
    copy_bytes(state, bytes + sizeof found, sizeof *state);
    expected = header_of(state);
    if (found.size != expected.size || found.checksum != expected.checksum) {
        return fail(it, "the serialised state is damaged");
    }
    return OK;
}

static void restore(Instance *it, const State *state) {
    it->now = *state;
    it->stale = 1;
}
