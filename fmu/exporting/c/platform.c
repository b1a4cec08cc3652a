/* Memory for instances and snapshots; on Windows without a C run-time library. */

#if defined(_WIN32)
__declspec(dllimport) void *__stdcall GetProcessHeap(void);
__declspec(dllimport) void *__stdcall HeapAlloc(void *heap, unsigned long flags, size_t size);
__declspec(dllimport) int __stdcall HeapFree(void *heap, unsigned long flags, void *memory);

static void *new_memory(size_t size) {
    return HeapAlloc(GetProcessHeap(), 8, size); /* 8: zeroed */
}

static void free_memory(void *memory) {
    if (memory) {
        HeapFree(GetProcessHeap(), 0, memory);
    }
}
#else
#include <stdlib.h>

static void *new_memory(size_t size) {
    return calloc(1, size);
}

static void free_memory(void *memory) {
    free(memory);
}
#endif

#if defined(NO_C_RUNTIME)
/* What the compiler itself calls. */
void *memcpy(void *restrict to, const void *restrict from, size_t size) {
    volatile unsigned char *target = to;
    const unsigned char *source = from;
    while (size--) {
        *target++ = *source++;
    }
    return to;
}

void *memset(void *memory, int value, size_t size) {
    volatile unsigned char *target = memory;
    while (size--) {
        *target++ = (unsigned char)value;
    }
    return memory;
}

int __stdcall DllMainCRTStartup(void *library, unsigned long reason, void *reserved) {
    (void)library, (void)reason, (void)reserved;
    return 1;
}
#endif
