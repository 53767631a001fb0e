/* The clocks of a computer that was suspended, for one program and its children (LD_PRELOAD).

   While a computer is suspended, CLOCK_MONOTONIC, CLOCK_MONOTONIC_RAW and CLOCK_MONOTONIC_COARSE
   stand still, and CLOCK_BOOTTIME goes on. The file that FREEZE_CLOCK names holds the time [ns] for
   which those three have stood still, as a 64-bit integer; it may grow while the processes do not
   run. Waits until a time of these clocks are shifted by it, and those that were under way go on
   for as long as was left of them. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#define SECOND 1000000000LL
/* pthread_cond_timedwait does not say of which clock its time is: none of the monotonic ones has
   counted thirty years. */
#define THIRTY_YEARS 946080000

static int (*get_time)(clockid_t, struct timespec *);
static int (*sleep_until)(clockid_t, int, const struct timespec *, struct timespec *);
static int (*wait_semaphore)(sem_t *, clockid_t, const struct timespec *);
static int (*wait_condition)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
static int (*wait_condition_by)(pthread_cond_t *, pthread_mutex_t *, clockid_t,
                                const struct timespec *);
static int (*lock_mutex)(pthread_mutex_t *, clockid_t, const struct timespec *);

static const volatile long long nothing;
static const volatile long long *stood = &nothing;

__attribute__((constructor)) static void begin(void) {
    if (get_time)
        return;
    const char *path = getenv("FREEZE_CLOCK");
    int file = path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (file >= 0) {
        void *page = mmap(NULL, sizeof *stood, PROT_READ, MAP_SHARED, file, 0);
        if (page != MAP_FAILED)
            stood = page;
        close(file);
    }
    sleep_until = dlsym(RTLD_NEXT, "clock_nanosleep");
    wait_semaphore = dlsym(RTLD_NEXT, "sem_clockwait");
    wait_condition = dlvsym(RTLD_NEXT, "pthread_cond_timedwait", "GLIBC_2.3.2");
    if (!wait_condition)
        wait_condition = dlsym(RTLD_NEXT, "pthread_cond_timedwait");
    wait_condition_by = dlsym(RTLD_NEXT, "pthread_cond_clockwait");
    lock_mutex = dlsym(RTLD_NEXT, "pthread_mutex_clocklock");
    get_time = dlsym(RTLD_NEXT, "clock_gettime");
}

static int stands(clockid_t clock) {
    return clock == CLOCK_MONOTONIC || clock == CLOCK_MONOTONIC_RAW ||
           clock == CLOCK_MONOTONIC_COARSE;
}

static struct timespec later(const struct timespec *time, long long by) {
    long long sum = time->tv_sec * SECOND + time->tv_nsec + by;
    return (struct timespec){sum / SECOND, sum % SECOND};
}

int clock_gettime(clockid_t clock, struct timespec *time) {
    begin();
    int failed = get_time(clock, time);
    if (!failed && stands(clock))
        *time = later(time, -*stood);
    return failed;
}

/* Call a function that waits until `until`, a time of this program, and again if the clock has
   stood still meanwhile. */
#define WAIT(result, until, over, call)                                                            \
    long long by;                                                                                  \
    do {                                                                                           \
        by = *stood;                                                                               \
        struct timespec due = later(until, by);                                                    \
        result = call;                                                                             \
    } while ((over) && by != *stood)

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *time,
                    struct timespec *left) {
    begin();
    if (!stands(clock) || !(flags & TIMER_ABSTIME))
        return sleep_until(clock, flags, time, left);
    int result;
    WAIT(result, time, result == 0, sleep_until(clock, flags, &due, left));
    return result;
}

int sem_clockwait(sem_t *semaphore, clockid_t clock, const struct timespec *time) {
    begin();
    if (!stands(clock))
        return wait_semaphore(semaphore, clock, time);
    int result;
    WAIT(result, time, result && errno == ETIMEDOUT, wait_semaphore(semaphore, clock, &due));
    return result;
}

int pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *mutex,
                           const struct timespec *time) {
    begin();
    if (time->tv_sec > THIRTY_YEARS)
        return wait_condition(condition, mutex, time);
    int result;
    WAIT(result, time, result == ETIMEDOUT, wait_condition(condition, mutex, &due));
    return result;
}

int pthread_cond_clockwait(pthread_cond_t *condition, pthread_mutex_t *mutex, clockid_t clock,
                           const struct timespec *time) {
    begin();
    if (!stands(clock))
        return wait_condition_by(condition, mutex, clock, time);
    int result;
    WAIT(result, time, result == ETIMEDOUT, wait_condition_by(condition, mutex, clock, &due));
    return result;
}

int pthread_mutex_clocklock(pthread_mutex_t *mutex, clockid_t clock, const struct timespec *time) {
    begin();
    if (!stands(clock))
        return lock_mutex(mutex, clock, time);
    int result;
    WAIT(result, time, result == ETIMEDOUT, lock_mutex(mutex, clock, &due));
    return result;
}
