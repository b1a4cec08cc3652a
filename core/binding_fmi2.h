/* A logger for FMUs of FMI 2.0 that hands plain text on. */
#ifndef JOUNCE_BINDING_FMI2_H
#define JOUNCE_BINDING_FMI2_H

#include <stdint.h>

#define JOUNCE_FMI2_MARK 0x4a4d4632

typedef void (*jounce_fmi2_note)(int status, const char *category, const char *text);

/* What an FMU is given as its environment, and gives back with each message. */
typedef struct {
    uint64_t mark; /* JOUNCE_FMI2_MARK */
    jounce_fmi2_note note;
} jounce_fmi2_environment;

typedef void (*jounce_fmi2_logger)(void *environment, const char *name, int status,
                                   const char *category, const char *message, ...);

/* The logger. `strays` receives the messages that come with another environment. */
jounce_fmi2_logger jounce_fmi2_log_to(jounce_fmi2_note strays);

#endif
