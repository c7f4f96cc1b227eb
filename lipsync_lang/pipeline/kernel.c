/* The stages of a performance, and the samples of pictures, compiled.

The numpy modules beside this file are its specification: every function here names the one that it
repeats, in the same order of operations wherever a comparison follows. The result agrees with theirs
to 1e-12. `kernel.py` prepares what is passed in, and says which settings are served.

Conventions: times are seconds; curves are (P, width), one row of frames per pose, as in the modules;
the tables and the result are (T, P). Sums run over frames or taps in a fixed order, so the same input
gives the same bytes, alone or in a batch, on every machine with IEEE doubles.

Safety: sizes are checked against the buffers, and numbers that become indices against their range,
before any is used. There is no static state; the GIL is released while the stages run. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030B0000
#include <Python.h>

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The loader chooses one of the clones. Their names are levels of the processor since GCC 12. */
#if !defined(__GNUC__) || defined(__clang__) || !defined(__x86_64__) || !defined(__gnu_linux__)
#define WIDE_VECTORS
#elif __GNUC__ >= 12
#define WIDE_VECTORS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#define SHUFFLES __builtin_cpu_supports("x86-64-v4") /* without AVX-512 these are slower than plain loops */
#else
#define WIDE_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
#endif

#if defined(__GNUC__) && !defined(__clang__)
#define IN_ANY_ORDER _Pragma("GCC ivdep") /* the loop reads nothing that it writes */
#else
#define IN_ANY_ORDER
#endif

#if defined(_MSC_VER)
#define RESTRICT __restrict
#define INLINE static __forceinline
#else
#define RESTRICT restrict
#define INLINE static inline __attribute__((always_inline))
#endif

typedef Py_ssize_t Size;
typedef unsigned char Byte;

#define INTERFACE 10        /* kernel.py: another number wherever calls or arguments change */
#define RESOLUTION 128      /* tables.py */
#define TOUCH 1e-7          /* warp.py */
#define MARGIN 0.030        /* hold.py */
#define SHORTEST 0.042      /* hold.py */
#define TAPS 3              /* of a kernel, on each side, that are summed together */
#define LANES 8             /* poses or frames read at once */
#define AT_ONCE 8           /* frames ahead of one that it is compared with at once */
#define CHAINS 10           /* rows whose running minima are computed at once */
#define LINE 64             /* bytes of a line of the processor's cache */
#define LATEST 1e9          /* seconds; beyond it frames have no place */
#define MAX_VIEWS 20

INLINE double least(double a, double b) { return a < b ? a : b; }
INLINE double most(double a, double b) { return a > b ? a : b; }
INLINE Size least_size(Size a, Size b) { return a < b ? a : b; }
INLINE Size most_size(Size a, Size b) { return a > b ? a : b; }

#if defined(SHUFFLES)
/* Turn LANES rows into columns: each turn lays the second half of the rows between those of the first. */
INLINE void shuffle(const double *from, Size step, double *RESTRICT to, Size to_step)
{
    typedef double Row __attribute__((vector_size(LANES * sizeof(double))));
    Row row[LANES], next[LANES];
    for (Size i = 0; i < LANES; i++)
        memcpy(&row[i], from + i * step, sizeof(Row));
    for (int turn = 0; turn < 3; turn++) {
        for (int i = 0; i < LANES / 2; i++) {
            next[2 * i] = __builtin_shufflevector(row[i], row[i + LANES / 2], 0, 8, 1, 9, 2, 10, 3, 11);
            next[2 * i + 1] = __builtin_shufflevector(row[i], row[i + LANES / 2], 4, 12, 5, 13, 6, 14, 7, 15);
        }
        memcpy(row, next, sizeof row);
    }
    for (Size i = 0; i < LANES; i++)
        memcpy(to + i * to_step, &row[i], sizeof(Row));
}
#else
#define SHUFFLES 0
#define shuffle(from, step, to, to_step) ((void)0)
#endif

/* Turn rows into columns: LANES rows at once, and the last ones alone. */
INLINE void transpose(const double *from, Size step, Size rows, Size columns, double *RESTRICT to, Size to_step)
{
    const Size whole = rows / LANES * LANES, shuffled = SHUFFLES ? columns / LANES * LANES : 0;
    for (Size i = 0; i < whole; i += LANES) {
        for (Size j = 0; j < shuffled; j += LANES)
            shuffle(from + i * step + j, step, to + j * to_step + i, to_step);
        for (Size j = shuffled; j < columns; j++)
            for (Size k = i; k < i + LANES; k++)
                to[j * to_step + k] = from[k * step + j];
    }
    for (Size i = whole; i < rows; i++)
        for (Size j = 0; j < columns; j++)
            to[j * to_step + i] = from[i * step + j];
}

/* ---------------------------------------------------------------- what is prepared once */

typedef struct {
    Py_buffer view[MAX_VIEWS];
    int views;
} Views;

typedef struct {
    Views views;
    Size rows, poses, phonemes, silence;
    const float *curves;    /* (rows, RESOLUTION + 1, poses) */
    const double *boundary; /* (rows,) */
    const Byte *free;       /* (rows,) */
    const Size *pairs;      /* (phonemes, phonemes) */
} Bank;

enum { CROSSFADE, LINEAR, HOLD, BEFORE, CLIP_HELD, CLIP_SLOW, TOPPED, AGAIN, FLAGS };
enum { POSES, PHONEMES, CONTACTS, EARLY, AHEAD, BINDING, PAIRS, RAMP, WIDE, SHARED, HALO, BLOCK, LEAD, CONTESTED, SIZES };
enum { FPS, STEP, SILENCE_REACH, SOUND_REACH, ADDED_SILENCE, NUMBERS };

typedef struct {
    Views views;
    PyObject *empty;             /* numpy.empty */
    const Byte *flag;            /* (FLAGS,) */
    const Size *size;            /* (SIZES,) */
    const double *number;        /* (NUMBERS,) */
    const double *ramps;         /* (P, RAMP) */
    const Size *early;           /* (EARLY,) poses */
    const double *left;          /* (EARLY, AHEAD + 1) */
    const double *blocked;       /* (EARLY, P) */
    const Byte *opposed;         /* (EARLY, PHONEMES) */
    const Byte *demands;         /* (CONTACTS, PHONEMES) */
    const double *levels;        /* (CONTACTS, 2, P) */
    const double *tops;          /* (P,) */
    const Byte *upper;           /* (P,) */
    const Size *low;             /* (BINDING,) */
    const double *threshold;     /* (BINDING,) */
    const Byte *high;            /* (BINDING, P) */
    const Size *at_most;         /* (PAIRS, 2) */
    const double *wide;          /* (P, WIDE + 1) half kernels; 0 in the middle where there is none */
    const double *shared;        /* (P, SHARED + 1) */
    const Size *contested;       /* (CONTESTED,) poses */
} Plan;

typedef struct {
    Size count;             /* n */
    const Size *ids;        /* (n,) */
    const double *bounds;   /* (n + 1,) */
    const double *reach;    /* (n,) */
    const double *moving;   /* (n,) */
    const Size *rows;       /* (n - 1,) */
    const Byte *waived;     /* (n,) */
} Track;

typedef struct {
    double start;
    Size first, count;
} Frames;

typedef struct {
    Py_buffer view[3];
    const Byte *poses;
    const double *times, *values;
    Size count;
} Dial;

typedef struct {
    Size contact, one, past; /* held in frames `one` to `past`, counted from the first of a block */
} Held;

typedef struct {
    double *curves;   /* (P, stride) */
    double *joined;   /* (stride, P) */
    double *fresh;    /* (EARLY, stride) */
    double *room;     /* (stride,) */
    double *row;      /* (stride + 2 reach,) */
    double *time;     /* (stride,) */
    double *share;    /* (stride,) of the bigram that begins */
    double *part[2];  /* (stride,) between two rows of the bank's curves, of the bigrams that end and begin */
    Size *row_of[2];  /* (stride,) these rows */
    Size *phoneme;    /* (stride,) */
    Size *begin;      /* (n,) first frame in the block of each phoneme there */
    double *boundary; /* (n + 1,) of the bigram before each phoneme, and of the one after the last */
    Size *bigram;     /* (n + 1,) first row of its curves */
    Held *held;       /* (CONTACTS * n + 1,) frames of contacts in the block, and the end of those found */
    Held *last_held;
    Size stride;
} Scratch;

/* ---------------------------------------------------------------- track.py, perform.py */

/* `lay_track`, without blends; fills arrays of n + 2 phonemes. */
static void lay_track(const Bank *bank, const Plan *plan, const Size *given, const double *times, Size count,
                      Track *track, Size *ids, double *bounds, double *reach, double *moving, Size *rows,
                      Byte *waived, int *head, int *tail)
{
    const Size silence = bank->silence;
    const double far = most(plan->number[SILENCE_REACH], 1e-9);
    const double added = most(plan->number[ADDED_SILENCE], 1e-9);
    Size n = 0;
    *head = given[0] != silence;
    *tail = given[count - 1] != silence;
    if (*head) {
        ids[n] = silence;
        bounds[n++] = times[0] - added;
    }
    for (Size i = 0; i < count; i++) {
        if (i && given[i] == silence && given[i - 1] == silence)
            continue;
        ids[n] = given[i];
        bounds[n++] = times[i];
    }
    bounds[n] = times[count];
    if (*tail) {
        ids[n++] = silence;
        bounds[n] = times[count] + added;
    }
    if (!*head)
        bounds[0] = least(bounds[0], bounds[1] - added);
    if (!*tail)
        bounds[n] = most(bounds[n], bounds[n - 1] + added);
    memset(waived, 0, (size_t)n);
    for (Size i = 0; i < n; i++) {
        const int quiet = ids[i] == silence;
        const double length = bounds[i + 1] - bounds[i];
        moving[i] = least(length, quiet ? far : plan->number[SOUND_REACH]);
        reach[i] = quiet ? moving[i] : length;
        if (i + 1 < n) {
            rows[i] = bank->pairs[ids[i] * bank->phonemes + ids[i + 1]];
            waived[i] |= bank->free[rows[i]];
            waived[i + 1] |= bank->free[rows[i]];
        }
    }
    *track = (Track){n, ids, bounds, reach, moving, rows, waived};
}

/* `_frames_until` */
static double frames_until(const Plan *plan, double edge, double sound)
{
    const double fps = plan->number[FPS];
    const double reached = floor((sound + plan->number[ADDED_SILENCE]) * fps + 1e-6);
    const double held = floor((sound + most(SHORTEST, 1 / fps) / 2) * fps + 1e-6);
    const double until = most(ceil(edge * fps - 1e-6), reached);
    return plan->size[LEAD] ? most(until, held + (double)plan->size[LEAD]) : until;
}

/* `lay_frames` */
static Frames lay_frames(const Plan *plan, const Track *track, double start, double end, int head, int tail)
{
    const double opening = head ? 0 : track->bounds[1] - start;
    const double closing = tail ? 0 : end - track->bounds[track->count - 1];
    const double length = end - start;
    const Size first = -(Size)frames_until(plan, 0, -opening);
    const Size last = (Size)frames_until(plan, length, length - closing);
    return (Frames){start, first, last - first + 1};
}

INLINE double seconds(const Plan *plan, const Frames *frames, Size frame)
{
    return frames->start + (double)(frames->first + frame) / plan->number[FPS];
}

/* `Frames.times` of some frames */
WIDE_VECTORS
static void fill_times(const Plan *plan, const Frames *frames, Size low, Size width, double *RESTRICT time)
{
    const double start = frames->start, first = (double)(frames->first + low), fps = plan->number[FPS];
    for (Size t = 0; t < width; t++)
        time[t] = start + (first + (double)t) / fps;
}

/* ---------------------------------------------------------------- warp.py */

/* `warp`: rows of a bigram's curves until a position in it */
INLINE double steps_at(double position)
{
    return least(most(position * RESOLUTION, 0), RESOLUTION - 1e-9);
}

INLINE double value_at(const float *under, Size poses, Size pose, double part)
{
    const float difference = under[poses + pose] - under[pose];
    return (double)difference * part + (double)under[pose];
}

/* The number of a frame's phoneme: as many inner bounds as are not after it. */
static Size phoneme_at(const Track *track, double time)
{
    Size low = 1, high = track->count; /* of bounds[1:-1] */
    while (low < high) {
        const Size middle = (low + high) / 2;
        if (track->bounds[middle] <= time)
            low = middle + 1;
        else
            high = middle;
    }
    return low - 1;
}

/* The bigrams beside each phoneme; rest before the first one and after the last. */
static void find_bigrams(const Bank *bank, const Plan *plan, const Track *track, Scratch *s)
{
    const Size n = track->count;
    s->boundary[0] = s->boundary[n] = 0;
    s->bigram[0] = s->bigram[n] = 0;
    for (Size i = 0; i + 1 < n; i++) {
        s->bigram[i + 1] = track->rows[i] * (RESOLUTION + 1);
        s->boundary[i + 1] = plan->flag[LINEAR] ? track->moving[i] / (track->moving[i] + track->moving[i + 1])
                                                : bank->boundary[track->rows[i]];
    }
}

/* `locate` and the positions of `warp`: the phoneme of each frame first, and then all frames alike, without
branches, so that some frames are worked on at once */
INLINE void locate(const Plan *plan, const Track *track, const Frames *frames, Size low, Size width, Scratch *s)
{
    const double *bounds = track->bounds, *lengths = track->moving, *reach = track->reach, *boundary = s->boundary;
    const Size last = track->count - 1, *bigram = s->bigram;
    const double *RESTRICT time = s->time;
    Size *RESTRICT phoneme = s->phoneme;
    fill_times(plan, frames, low, width, s->time);
    Size at = phoneme_at(track, time[0] + TOUCH);
    s->begin[at] = 0;
    for (Size t = 0; t < width; t++) {
        while (at < last && bounds[at + 1] <= time[t] + TOUCH)
            s->begin[++at] = t;
        phoneme[t] = at;
    }
    double *RESTRICT share = s->share, *RESTRICT ended = s->part[0], *RESTRICT begun = s->part[1];
    Size *RESTRICT ending = s->row_of[0], *RESTRICT beginning = s->row_of[1];
    IN_ANY_ORDER
    for (Size t = 0; t < width; t++) {
        const Size here = phoneme[t], before = bigram[here], after = bigram[here + 1];
        const double moving = lengths[here], since = time[t] - bounds[here], until = bounds[here + 1] - time[t];
        const double capped = least(since, most(moving / 2, moving - until));
        const double passed = moving < reach[here] ? capped : since, rest = moving - passed;
        const double left = moving < reach[here] ? rest : until;
        const double onward = most(passed, 0) / moving, back = 1 - left / moving;
        const double coming = fabs(passed - moving) <= TOUCH ? 1.0 : onward;
        const double going = fabs(left - moving) <= TOUCH ? 0.0 : back;
        share[t] = least(most(going, 0), 1);
        ended[t] = steps_at(boundary[here] + (1 - boundary[here]) * coming);
        begun[t] = steps_at(boundary[here + 1] * going);
        ending[t] = coming <= 1 ? before : 0;
        beginning[t] = going >= 0 ? after : 0;
    }
    for (int side = 0; side < 2; side++) { /* whole steps are rows, and the rest is a share of the next one */
        double *RESTRICT steps = s->part[side];
        Size *RESTRICT row = s->row_of[side];
        for (Size t = 0; t < width; t++) {
            const int whole = (int)steps[t];
            steps[t] -= whole;
            row[t] += whole;
        }
    }
}

/* `warp` and `stitch` of LANES poses */
INLINE void join(const float *ending, const float *beginning, Size poses, Size pose, int lanes, const double *part,
                 double *RESTRICT out)
{
    for (Size p = pose; p < pose + lanes; p++)
        out[p] = most(value_at(ending, poses, p, part[0]), value_at(beginning, poses, p, part[1]));
}

/* `warp` and `stitch` */
INLINE void stitch(const Bank *bank, const Plan *plan, const Track *track, const Frames *frames, Size low, Size width,
                   Scratch *s)
{
    const Size poses = bank->poses;
    locate(plan, track, frames, low, width, s);
    for (Size t = 0; t < width; t++) {
        const float *ending = bank->curves + s->row_of[0][t] * poses;
        const float *beginning = bank->curves + s->row_of[1][t] * poses;
        const double part[2] = {s->part[0][t], s->part[1][t]}, share = s->share[t];
        double *RESTRICT out = s->joined + t * poses;
        if (plan->flag[CROSSFADE])
            for (Size p = 0; p < poses; p++)
                out[p] = value_at(ending, poses, p, part[0]) * (1 - share) +
                         value_at(beginning, poses, p, part[1]) * share;
        else if (poses < LANES)
            for (Size p = 0; p < poses; p++)
                join(ending, beginning, poses, p, 1, part, out);
        else
            for (Size p = 0; p < poses; p += LANES) /* the last ones overlap those before them */
                join(ending, beginning, poses, least_size(p, poses - LANES), LANES, part, out);
    }
    if (track->count == 1) /* nothing but silence */
        memset(s->joined, 0, (size_t)(width * poses) * sizeof(double));
    transpose(s->joined, poses, width, poses, s->curves, s->stride);
}

/* ---------------------------------------------------------------- levels.py */

/* `scale`: numpy.interp of each level, walked along the frames */
INLINE void scale(const Plan *plan, const Dial *dials, Size dial_count, Size width, Scratch *s)
{
    const Size poses = plan->size[POSES];
    double *RESTRICT level = s->row;
    for (Size d = 0; d < dial_count; d++) {
        const Dial *dial = dials + d;
        const double *at = dial->times, *value = dial->values;
        const Size last = dial->count - 1;
        Size k = -1; /* the last point that is not after the frame */
        for (Size t = 0; t < width; t++) {
            const double time = s->time[t];
            while (k < last && at[k + 1] <= time)
                k++;
            if (k < 0)
                level[t] = value[0];
            else if (k == last)
                level[t] = value[last];
            else
                level[t] = (value[k + 1] - value[k]) / (at[k + 1] - at[k]) * (time - at[k]) + value[k];
        }
        for (Size p = 0; p < poses; p++) {
            double *RESTRICT row = s->curves + p * s->stride;
            if (dial->poses[p])
                for (Size t = 0; t < width; t++)
                    row[t] *= level[t];
        }
    }
    for (Size p = 0; p < poses; p++) {
        double *RESTRICT row = s->curves + p * s->stride;
        int scaled = 0;
        for (Size d = 0; d < dial_count; d++)
            scaled |= dials[d].poses[p];
        if (scaled)
            for (Size t = 0; t < width; t++)
                row[t] = least(row[t], 1);
    }
}

/* ---------------------------------------------------------------- anticipate.py */

/* `anticipate`, with the room that opponents leave, as in `Performance._shaped` */
INLINE void anticipate(const Plan *plan, const Track *track, Size width, Scratch *s)
{
    const Size poses = plan->size[POSES], phonemes = plan->size[PHONEMES], ahead = plan->size[AHEAD];
    const Size last = s->phoneme[width - 1];
    for (Size r = 0; r < plan->size[EARLY]; r++) {
        double *RESTRICT room = s->room, *RESTRICT out = s->fresh + r * s->stride;
        double *RESTRICT own = s->curves + plan->early[r] * s->stride;
        const double *left = plan->left + r * (ahead + 1), *blocked = plan->blocked + r * poses;
        const Byte *opposed = plan->opposed + r * phonemes;
        for (Size t = 0; t < width; t++)
            room[t] = 1;
        for (Size p = 0; p < poses; p++) {
            const double *RESTRICT row = s->curves + p * s->stride;
            const double much = blocked[p];
            if (much != 0)
                for (Size t = 0; t < width; t++)
                    room[t] -= much * row[t];
        }
        for (Size t = 0; t < width; t++)
            room[t] = most(room[t], 0);
        for (Size at = s->phoneme[0]; at <= last; at++) {
            const Size end = at < last ? s->begin[at + 1] : width;
            for (Size t = s->begin[at]; opposed[track->ids[at]] && t < end; t++)
                room[t] = 0;
        }
        double *RESTRICT narrowest = s->row;
        memcpy(out, own, (size_t)width * sizeof(double));
        memcpy(narrowest, room, (size_t)width * sizeof(double));
        for (Size t = width; t < width + AT_ONCE - 1; t++)
            own[t] = room[t] = 0;
        for (Size far = 1; far <= ahead && far < width && left[far] > 0; far += AT_ONCE) { /* to load less */
            const double *RESTRICT later = own + far, *RESTRICT between = room + far;
            double shares[AT_ONCE];
            for (Size i = 0; i < AT_ONCE; i++)
                shares[i] = far + i <= ahead ? left[far + i] : 0;
            for (Size t = 0; t < width - far; t++) {
                double best = out[t], narrow = narrowest[t];
                for (Size i = 0; i < AT_ONCE; i++) {
                    best = most(best, least(shares[i] * later[t + i], narrow));
                    narrow = least(narrow, between[t + i]);
                }
                out[t] = best;
                narrowest[t] = narrow;
            }
        }
    }
    for (Size r = 0; r < plan->size[EARLY]; r++)
        memcpy(s->curves + plan->early[r] * s->stride, s->fresh + r * s->stride, (size_t)width * sizeof(double));
}

/* ---------------------------------------------------------------- soften.py */

/* `_round` by at most 2 TAPS weights on each side, in one pass; `c` are the frames, with zeros around them */
INLINE void round_near(double *RESTRICT row, Size width, const double *half, const int reach, const double *RESTRICT c)
{
    double weight[2 * TAPS + 1];
    for (int j = 0; j <= reach; j++)
        weight[j] = half[j];
    for (Size t = 0; t < width; t++) {
        double sum = weight[0] * c[t], farther = 0;
        for (int j = 1; j <= reach && j <= TAPS; j++)
            sum += weight[j] * (c[t - j] + c[t + j]);
        for (int j = TAPS + 1; j <= reach; j++)
            farther += weight[j] * (c[t - j] + c[t + j]);
        row[t] = sum + farther;
    }
}

/* `_round`: `reach` is a multiple of TAPS, the half kernel being filled up with zeros */
INLINE void round_off(double *RESTRICT row, Size width, const double *half, Size reach, const double *RESTRICT c)
{
    round_near(row, width, half, 2 * TAPS, c);
    for (Size j = 2 * TAPS + 1; j <= reach; j += TAPS) {
        const double one = half[j], two = half[j + 1], three = half[j + 2];
        for (Size t = 0; t < width; t++)
            row[t] += one * (c[t - j] + c[t + j]) + two * (c[t - j - 1] + c[t + j + 1]) +
                      three * (c[t - j - 2] + c[t + j + 2]);
    }
}

/* `soften` */
INLINE void soften(const Plan *plan, const double *kernels, Size reach, Size width, Scratch *s)
{
    double *c = s->row + reach;
    memset(s->row, 0, (size_t)reach * sizeof(double));
    memset(c + width, 0, (size_t)reach * sizeof(double));
    for (Size p = 0; reach && p < plan->size[POSES]; p++) {
        const double *half = kernels + p * (reach + 1);
        double *row = s->curves + p * s->stride;
        Size own = reach;
        while (own && half[own] == 0)
            own--;
        if (!(half[0] > 0))
            continue;
        memcpy(c, row, (size_t)width * sizeof(double));
        switch (own) { /* each its own loop, without weights that are 0 */
        case 0:
        case 1: round_near(row, width, half, 1, c); break;
        case 2: round_near(row, width, half, 2, c); break;
        case 3: round_near(row, width, half, 3, c); break;
        case 4: round_near(row, width, half, 4, c); break;
        case 5: round_near(row, width, half, 5, c); break;
        case 6: round_near(row, width, half, 6, c); break;
        default: round_off(row, width, half, reach, c); break;
        }
    }
}

/* ---------------------------------------------------------------- hold.py */

/* The phonemes that may be held in some frames, from `*begin` to the returned one */
INLINE Size near(const Plan *plan, const Track *track, const Frames *frames, Size low, Size width, Size *begin)
{
    const double fps = plan->number[FPS], reach = most(SHORTEST, 1 / fps) / 2;
    *begin = phoneme_at(track, seconds(plan, frames, low) - reach - 2 / fps);
    return phoneme_at(track, seconds(plan, frames, low + width) + reach + 2 / fps) + 1;
}

/* `held_frames` of one phoneme: the frames from `*one` to the returned one, counted from `low` */
INLINE Size held(const Plan *plan, const Track *track, const Frames *frames, const Byte *demanding, Size at, Size low,
                 Size width, Size *one)
{
    const double fps = plan->number[FPS], reach = most(SHORTEST, 1 / fps) / 2;
    const double origin = frames->start + (double)frames->first / fps;
    *one = width;
    if (!demanding[track->ids[at]] || track->waived[at])
        return 0;
    const Size n = track->count, before = at ? at - 1 : n - 1, after = at + 1 < n ? at + 1 : at;
    const int since = demanding[track->ids[before]] && !track->waived[before];
    const int on = after != at && demanding[track->ids[after]] && !track->waived[after];
    const double start = track->bounds[at], end = track->bounds[at + 1], middle = (start + end) / 2;
    const double from = least(since ? start : start + MARGIN, middle - reach);
    const double to = most(on ? end : end - MARGIN, middle + reach);
    *one = most_size((Size)ceil((from - origin) * fps - 1e-6) - low, 0);
    return least_size((Size)floor((to - origin) * fps + 1e-6) + 1 - low, width);
}

/* `hold`, over the phonemes near the frames; what is held stays in `s` for `contest` */
INLINE void hold(const Plan *plan, const Track *track, const Frames *frames, Size low, Size width, Scratch *s)
{
    const Size poses = plan->size[POSES];
    Size begin;
    const Size stop = near(plan, track, frames, low, width, &begin);
    Held *last = s->held;
    for (Size c = 0; c < plan->size[CONTACTS]; c++) {
        const Byte *demanding = plan->demands + c * plan->size[PHONEMES];
        const double *floors = plan->levels + c * 2 * poses, *ceilings = floors + poses;
        for (Size at = begin; at < stop; at++) {
            *last = (Held){.contact = c};
            last->past = held(plan, track, frames, demanding, at, low, width, &last->one);
            if (last->one >= last->past)
                continue;
            for (Size p = 0; p < poses; p++) {
                double *RESTRICT row = s->curves + p * s->stride;
                if (floors[p] > -LATEST || ceilings[p] < LATEST)
                    for (Size t = last->one; t < last->past; t++)
                        row[t] = least(most(row[t], floors[p]), ceilings[p]);
            }
            last++;
        }
    }
    s->last_held = last;
}

/* `Performance._contest`; beyond `far` frames a slope is out of the bounds, and `limit` cuts it there */
INLINE void contest(const Plan *plan, Size width, Scratch *s)
{
    const Size poses = plan->size[POSES];
    const double step = plan->number[STEP];
    for (Size turn = 0; turn < plan->size[CONTACTS] * 2 * plan->size[CONTESTED]; turn++) {
        const Size c = turn / (2 * plan->size[CONTESTED]), p = plan->contested[turn / 2 % plan->size[CONTESTED]];
        const int raises = turn % 2;
        const double level = plan->levels[(2 * c + !raises) * poses + p];
        const double room = raises ? level : 1 - level;
        double *RESTRICT row = s->curves + p * s->stride;
        if (!(fabs(level) < LATEST))
            continue;
        const Size far = (Size)ceil(most(room, 0) / step);
        for (const Held *now = s->held; now < s->last_held; now++) {
            const Size one = now->one, past = now->past, end = now->contact == c ? least_size(past + far, width) : 0;
            for (Size t = most_size(one - far, 0); t < end; t++) {
                const double away = step * (double)most_size(most_size(one - t, t - past + 1), 0);
                row[t] = raises ? most(row[t], level - away) : least(row[t], level + away);
            }
        }
    }
}

/* ---------------------------------------------------------------- limit.py, constrain.py */

/* `rest_at_ends` */
INLINE void rest_at_ends(const Plan *plan, Size width, int head, int tail, Scratch *s)
{
    const Size count = least_size(width, plan->size[RAMP]);
    for (Size p = 0; p < plan->size[POSES]; p++) {
        double *row = s->curves + p * s->stride;
        const double *ramp = plan->ramps + p * plan->size[RAMP];
        for (Size t = 0; head && t < count; t++)
            row[t] = least(row[t], ramp[t]);
        for (Size t = 0; tail && t < count; t++)
            row[width - 1 - t] = least(row[width - 1 - t], ramp[t]);
    }
}

/* `lower_envelope` of some rows at once: each minimum waits for the one before it, not for its neighbours */
INLINE void lower_rows(double *const *rows, Size width, double step, const int count)
{
    double slow[CHAINS];
    for (int i = 0; i < count; i++)
        slow[i] = rows[i][0];
    for (Size t = 1; t < width; t++)
        for (int i = 0; i < count; i++) {
            slow[i] = least(rows[i][t], slow[i] + step);
            rows[i][t] = slow[i];
        }
    for (Size t = width - 2; t >= 0; t--)
        for (int i = 0; i < count; i++) {
            slow[i] = least(rows[i][t], slow[i] + step);
            rows[i][t] = slow[i];
        }
}

INLINE void flip(double *RESTRICT row, Size width)
{
    for (Size t = 0; t < width; t++)
        row[t] = -row[t];
}

INLINE void clip(const Plan *plan, const double *tops, int below, Size width, Scratch *s)
{
    for (Size p = 0; p < plan->size[POSES]; p++) {
        double *RESTRICT row = s->curves + p * s->stride;
        const double top = tops ? tops[p] : 1;
        for (Size t = 0; t < width; t++)
            row[t] = least(below ? most(row[t], 0) : row[t], top);
    }
}

/* `envelope`: an upper one is the lower one of the negative, negated */
INLINE void limit(const Plan *plan, Size width, Scratch *s)
{
    const Size poses = plan->size[POSES];
    const double step = plan->number[STEP];
    const Size groups = (poses + CHAINS - 1) / CHAINS;
    for (Size p = 0; p < poses; p++)
        if (plan->upper[p])
            flip(s->curves + p * s->stride, width);
    for (Size g = 0; g < groups; g++) {
        double *rows[CHAINS];
        const Size begin = g * poses / groups;
        const int count = (int)((g + 1) * poses / groups - begin);
        for (int i = 0; i < count; i++)
            rows[i] = s->curves + (begin + i) * s->stride;
        switch (count) { /* each its own loop, with its minima in registers */
        case 1: lower_rows(rows, width, step, 1); break;
        case 2: lower_rows(rows, width, step, 2); break;
        case 3: lower_rows(rows, width, step, 3); break;
        case 4: lower_rows(rows, width, step, 4); break;
        case 5: lower_rows(rows, width, step, 5); break;
        case 6: lower_rows(rows, width, step, 6); break;
        case 7: lower_rows(rows, width, step, 7); break;
        case 8: lower_rows(rows, width, step, 8); break;
        case 9: lower_rows(rows, width, step, 9); break;
        default: lower_rows(rows, width, step, CHAINS); break;
        }
    }
    for (Size p = 0; p < poses; p++)
        if (plan->upper[p])
            flip(s->curves + p * s->stride, width);
    if (plan->size[CONTESTED])
        contest(plan, width, s);
    if (plan->flag[CLIP_SLOW])
        clip(plan, plan->tops, 1, width, s);
}

/* `constrain` */
INLINE void constrain(const Plan *plan, Size width, Scratch *s)
{
    const Size poses = plan->size[POSES];
    for (Size k = 0; k < plan->size[BINDING]; k++) {
        double *RESTRICT row = s->curves + plan->low[k] * s->stride;
        const double threshold = plan->threshold[k];
        for (Size p = 0; p < poses; p++) {
            const double *RESTRICT other = s->curves + p * s->stride;
            if (plan->high[k * poses + p])
                for (Size t = 0; t < width; t++)
                    row[t] = least(row[t], most(threshold - other[t], 0));
        }
    }
    for (Size k = 0; k < plan->size[PAIRS]; k++) {
        double *RESTRICT row = s->curves + plan->at_most[2 * k] * s->stride;
        const double *RESTRICT other = s->curves + plan->at_most[2 * k + 1] * s->stride;
        for (Size t = 0; t < width; t++)
            row[t] = least(row[t], other[t]);
    }
}

/* ---------------------------------------------------------------- perform.py */

/* `Performance._run` on frames `begin` to `stop`, and on those that they depend on within the span */
WIDE_VECTORS
static void run_block(const Bank *bank, const Plan *plan, const Track *track, const Dial *dials, Size dial_count,
                      const Frames *frames, const Size *span, Size begin, Size stop, Scratch *s,
                      double *RESTRICT out)
{
    const Size poses = plan->size[POSES], halo = plan->size[HALO];
    const Size low = most_size(span[0], begin - halo), high = least_size(span[1], stop + halo);
    const Size width = high - low;
    stitch(bank, plan, track, frames, low, width, s);
    if (dial_count)
        scale(plan, dials, dial_count, width, s);
    if (plan->size[EARLY])
        anticipate(plan, track, width, s);
    soften(plan, plan->wide, plan->size[WIDE], width, s);
    rest_at_ends(plan, width, low == 0, high == frames->count, s);
    if (plan->flag[TOPPED])
        clip(plan, plan->tops, 0, width, s);
    if (plan->flag[HOLD])
        hold(plan, track, frames, low, width, s);
    if (plan->flag[CLIP_HELD])
        clip(plan, NULL, 1, width, s);
    if (plan->flag[BEFORE]) {
        limit(plan, width, s);
        constrain(plan, width, s);
    } else {
        constrain(plan, width, s);
        limit(plan, width, s);
    }
    soften(plan, plan->shared, plan->size[SHARED], width, s);
    if (plan->flag[AGAIN])
        constrain(plan, width, s);
    transpose(s->curves + begin - low, s->stride, poses, stop - begin, out, poses);
}

/* `Performance.last` on a span of frames; returns -1 where there is no memory */
static int run_all(const Bank *bank, const Plan *plan, const Track *track, const Dial *dials, Size dial_count,
                   const Frames *frames, const Size *span, double *out)
{
    const Size poses = plan->size[POSES], block = plan->size[BLOCK], early = plan->size[EARLY];
    const Size longest = least_size(span[1] - span[0], block + 2 * plan->size[HALO]) + AT_ONCE;
    const Size stride = (longest / 16 * 2 + 3) * 8; /* an odd number of cache lines, so that rows do not compete */
    const Size reach = most_size(plan->size[WIDE], plan->size[SHARED]);
    const Size n = track->count;
    const size_t doubles = (size_t)stride * (size_t)(2 * poses + early + 6) + 2 * (size_t)reach + (size_t)n + 1;
    const size_t sizes = 3 * (size_t)stride + 2 * (size_t)n + 1, contacts = (size_t)(plan->size[CONTACTS] * n + 1);
    void *room = malloc(doubles * sizeof(double) + sizes * sizeof(Size) + contacts * sizeof(Held) + LINE);
    if (!room)
        return -1;
    double *memory = (double *)((char *)room + LINE - (size_t)room % LINE);
    Scratch s = {.curves = memory, .stride = stride};
    s.joined = s.curves + poses * stride;
    s.fresh = s.joined + poses * stride;
    s.room = s.fresh + early * stride;
    s.time = s.room + stride;
    s.share = s.time + stride;
    s.part[0] = s.share + stride;
    s.part[1] = s.part[0] + stride;
    s.boundary = s.part[1] + stride;
    s.row = s.boundary + n + 1;
    s.phoneme = (Size *)(memory + doubles);
    s.row_of[0] = s.phoneme + stride;
    s.row_of[1] = s.row_of[0] + stride;
    s.bigram = s.row_of[1] + stride;
    s.begin = s.bigram + n + 1;
    s.held = s.last_held = (Held *)(s.phoneme + sizes);
    find_bigrams(bank, plan, track, &s);
    for (Size begin = span[0]; begin < span[1]; begin += block) {
        const Size stop = least_size(begin + block, span[1]);
        double *here = out + (begin - span[0]) * poses;
        run_block(bank, plan, track, dials, dial_count, frames, span, begin, stop, &s, here);
    }
    free(room);
    return 0;
}

/* ---------------------------------------------------------------- Python's side */

static void release_views(Views *views)
{
    while (views->views)
        PyBuffer_Release(&views->view[--views->views]);
}

/* Keep a view of an array's bytes; NULL, with an exception, unless it has so many items. */
static const void *keep(Views *views, PyObject *array, size_t item, Size items, const char *name)
{
    Py_buffer *view = &views->view[views->views];
    if (PyObject_GetBuffer(array, view, PyBUF_SIMPLE) < 0)
        return NULL;
    views->views++;
    if (items < 0 || view->len != (Size)item * items) {
        PyErr_Format(PyExc_ValueError, "%s: %zd bytes for %zd items", name, view->len, items);
        return NULL;
    }
    return view->buf;
}

/* Keep a view of an array that is changed in place; see `keep`. */
static void *keep_writable(Views *views, PyObject *array, size_t item, Size items, const char *name)
{
    Py_buffer *view = &views->view[views->views];
    if (PyObject_GetBuffer(array, view, PyBUF_WRITABLE | PyBUF_FORMAT) < 0)
        return NULL;
    views->views++;
    if (view->format && strchr(view->format, 'O')) { /* numbers are no references */
        PyErr_Format(PyExc_TypeError, "%s: Python's objects instead of numbers", name);
        return NULL;
    }
    if (items < 0 || view->len != (Size)item * items) {
        PyErr_Format(PyExc_ValueError, "%s: %zd bytes for %zd items", name, view->len, items);
        return NULL;
    }
    return view->buf;
}

static int within(const Size *numbers, Size count, Size stop, const char *name)
{
    for (Size i = 0; i < count; i++)
        if (numbers[i] < 0 || numbers[i] >= stop) {
            PyErr_Format(PyExc_ValueError, "%s: %zd is not below %zd", name, numbers[i], stop);
            return 0;
        }
    return 1;
}

static void free_bank(PyObject *capsule)
{
    Bank *bank = PyCapsule_GetPointer(capsule, "lipsync_lang.bank");
    release_views(&bank->views);
    PyMem_Free(bank);
}

static PyObject *make_bank(PyObject *module, PyObject *args)
{
    PyObject *curves, *boundary, *waives, *pairs;
    Bank *bank = PyMem_Calloc(1, sizeof(Bank));
    (void)module;
    if (!bank)
        return PyErr_NoMemory();
    if (!PyArg_ParseTuple(args, "nnnnOOOO", &bank->rows, &bank->poses, &bank->phonemes, &bank->silence, &curves,
                          &boundary, &waives, &pairs))
        goto fail;
    const Size limit = PY_SSIZE_T_MAX / 1024;
    if (bank->rows < 1 || bank->poses < 1 || bank->phonemes < 1 || bank->phonemes > 0xffff ||
        bank->poses > 0xffff || bank->rows > limit / bank->poses ||
        !within(&bank->silence, 1, bank->phonemes, "silence")) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "a bank without rows, poses or phonemes");
        goto fail;
    }
    const Size values = bank->rows * (RESOLUTION + 1) * bank->poses, squared = bank->phonemes * bank->phonemes;
    if (!(bank->curves = keep(&bank->views, curves, sizeof(float), values, "curves")) ||
        !(bank->boundary = keep(&bank->views, boundary, sizeof(double), bank->rows, "boundary")) ||
        !(bank->free = keep(&bank->views, waives, 1, bank->rows, "free")) ||
        !(bank->pairs = keep(&bank->views, pairs, sizeof(Size), squared, "pairs")) ||
        !within(bank->pairs, squared, bank->rows, "pairs"))
        goto fail;
    PyObject *capsule = PyCapsule_New(bank, "lipsync_lang.bank", free_bank);
    if (capsule)
        return capsule;
fail:
    release_views(&bank->views);
    PyMem_Free(bank);
    return NULL;
}

static void discard_plan(Plan *plan)
{
    release_views(&plan->views);
    Py_XDECREF(plan->empty);
    PyMem_Free(plan);
}

static void free_plan(PyObject *capsule)
{
    discard_plan(PyCapsule_GetPointer(capsule, "lipsync_lang.plan"));
}

static int sound_plan(const Plan *plan)
{
    const Size *size = plan->size;
    for (int i = 0; i < SIZES; i++)
        if (size[i] < 0 || size[i] > 0xffffff) {
            PyErr_Format(PyExc_ValueError, "size %d: %zd", i, size[i]);
            return 0;
        }
    if (!size[POSES] || !size[PHONEMES] || !size[RAMP] || !size[BLOCK] || size[WIDE] % TAPS || size[SHARED] % TAPS ||
        !(plan->number[FPS] > 1e-3 && plan->number[FPS] < 1e6)) {
        PyErr_SetString(PyExc_ValueError, "a plan without poses, phonemes or frames");
        return 0;
    }
    return 1;
}

static PyObject *make_plan(PyObject *module, PyObject *args)
{
    PyObject *a[18];
    Plan *plan = PyMem_Calloc(1, sizeof(Plan));
    (void)module;
    if (!plan)
        return PyErr_NoMemory();
    if (!PyArg_ParseTuple(args, "OOOOOOOOOOOOOOOOOOO", &plan->empty, &a[0], &a[1], &a[2], &a[3], &a[4], &a[5], &a[6],
                          &a[7], &a[8], &a[9], &a[10], &a[11], &a[12], &a[13], &a[14], &a[15], &a[16], &a[17])) {
        plan->empty = NULL;
        goto fail;
    }
    Py_INCREF(plan->empty);
    Views *v = &plan->views;
    if (!(plan->flag = keep(v, a[0], 1, FLAGS, "flags")) ||
        !(plan->size = keep(v, a[1], sizeof(Size), SIZES, "sizes")) ||
        !(plan->number = keep(v, a[2], sizeof(double), NUMBERS, "numbers")) || !sound_plan(plan))
        goto fail;
    const Size *n = plan->size, poses = n[POSES];
    if (!(plan->ramps = keep(v, a[3], sizeof(double), poses * n[RAMP], "ramps")) ||
        !(plan->early = keep(v, a[4], sizeof(Size), n[EARLY], "early")) ||
        !(plan->left = keep(v, a[5], sizeof(double), n[EARLY] * (n[AHEAD] + 1), "left")) ||
        !(plan->blocked = keep(v, a[6], sizeof(double), n[EARLY] * poses, "blocked")) ||
        !(plan->opposed = keep(v, a[7], 1, n[EARLY] * n[PHONEMES], "opposed")) ||
        !(plan->demands = keep(v, a[8], 1, n[CONTACTS] * n[PHONEMES], "demands")) ||
        !(plan->levels = keep(v, a[9], sizeof(double), n[CONTACTS] * 2 * poses, "levels")) ||
        !(plan->tops = keep(v, a[10], sizeof(double), poses, "tops")) ||
        !(plan->upper = keep(v, a[11], 1, poses, "upper")) ||
        !(plan->low = keep(v, a[12], sizeof(Size), n[BINDING], "low")) ||
        !(plan->threshold = keep(v, a[13], sizeof(double), n[BINDING], "threshold")) ||
        !(plan->high = keep(v, a[14], 1, n[BINDING] * poses, "high")) ||
        !(plan->at_most = keep(v, a[15], sizeof(Size), 2 * n[PAIRS], "at_most")) ||
        !(plan->wide = keep(v, a[16], sizeof(double), poses * (n[WIDE] + n[SHARED] + 2), "kernels")) ||
        !(plan->contested = keep(v, a[17], sizeof(Size), n[CONTESTED], "contested")))
        goto fail;
    plan->shared = plan->wide + poses * (n[WIDE] + 1);
    if (!within(plan->early, n[EARLY], poses, "early") || !within(plan->low, n[BINDING], poses, "low") ||
        !within(plan->at_most, 2 * n[PAIRS], poses, "at_most") ||
        !within(plan->contested, n[CONTESTED], poses, "contested"))
        goto fail;
    PyObject *capsule = PyCapsule_New(plan, "lipsync_lang.plan", free_plan);
    if (capsule)
        return capsule;
fail:
    discard_plan(plan);
    return NULL;
}

static int fits(const Bank *bank, const Plan *plan)
{
    if (bank->poses == plan->size[POSES] && bank->phonemes == plan->size[PHONEMES])
        return 1;
    PyErr_SetString(PyExc_ValueError, "a plan of other poses or phonemes than the bank's");
    return 0;
}

/* Times never fall, and none is so far away that frames could not be counted; NaN is neither. */
static int rising(const double *times, Size count)
{
    int sound = times[0] > -LATEST && times[count - 1] < LATEST;
    for (Size i = 0; i + 1 < count; i++)
        sound &= times[i + 1] >= times[i];
    if (!sound)
        PyErr_SetString(PyExc_ValueError, "times fall, or are out of range");
    return sound;
}

static void release_dials(Dial *dials, Size count)
{
    for (Size d = 0; d < count; d++)
        for (int i = 0; i < 3; i++)
            PyBuffer_Release(&dials[d].view[i]);
    PyMem_Free(dials);
}

/* Return an item of a tuple, or NULL with an exception. */
static PyObject *item(PyObject *tuple, Size at)
{
    if (PyTuple_Check(tuple))
        return PyTuple_GetItem(tuple, at);
    PyErr_SetString(PyExc_TypeError, "dials are a tuple of tuples");
    return NULL;
}

/* Read a tuple of (poses, times, values); -1 with an exception where one is faulty. */
static Size read_dials(PyObject *given, const Plan *plan, Dial **dials)
{
    *dials = NULL;
    const Size count = PyTuple_Check(given) ? PyTuple_Size(given) : 1;
    if (count <= 0)
        return count;
    Dial *made = PyMem_Calloc((size_t)count, sizeof(Dial));
    if (!made) {
        PyErr_NoMemory();
        return -1;
    }
    for (Size d = 0; d < count; d++) {
        Dial *dial = made + d;
        PyObject *parts = item(given, d);
        for (int i = 0; i < 3; i++) {
            PyObject *part = parts ? item(parts, i) : NULL;
            if (!part || PyObject_GetBuffer(part, &dial->view[i], PyBUF_SIMPLE) < 0) {
                while (i--)
                    PyBuffer_Release(&dial->view[i]);
                release_dials(made, d);
                return -1;
            }
        }
        dial->poses = dial->view[0].buf;
        dial->times = dial->view[1].buf;
        dial->values = dial->view[2].buf;
        dial->count = dial->view[1].len / (Size)sizeof(double);
        if (dial->view[0].len != plan->size[POSES] || dial->count < 1 || dial->view[2].len != dial->view[1].len) {
            PyErr_SetString(PyExc_ValueError, "a dial of other poses, or without points");
            release_dials(made, d + 1);
            return -1;
        }
    }
    *dials = made;
    return count;
}

/* Call numpy.empty(shape) and give its memory. */
static PyObject *new_array(PyObject *empty, Py_buffer *view, Size rows, Size columns)
{
    PyObject *array = columns ? PyObject_CallFunction(empty, "((nn))", rows, columns)
                              : PyObject_CallFunction(empty, "n", rows);
    if (!array)
        return NULL;
    if (PyObject_GetBuffer(array, view, PyBUF_WRITABLE) < 0) {
        Py_DECREF(array);
        return NULL;
    }
    if (view->len != rows * (columns ? columns : 1) * (Size)sizeof(double)) {
        PyErr_SetString(PyExc_ValueError, "an array of another size");
        PyBuffer_Release(view);
        Py_DECREF(array);
        return NULL;
    }
    return array;
}

/* Perform a span of frames of a track: (T, P) as a new array. */
static PyObject *performed(const Bank *bank, const Plan *plan, const Track *track, const Dial *dials,
                           Size dial_count, const Frames *frames, const Size *span)
{
    Py_buffer out;
    int done;
    PyObject *weights = new_array(plan->empty, &out, span[1] - span[0], plan->size[POSES]);
    if (!weights)
        return NULL;
    Py_BEGIN_ALLOW_THREADS
    done = run_all(bank, plan, track, dials, dial_count, frames, span, out.buf);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&out);
    if (done < 0) {
        Py_DECREF(weights);
        return PyErr_NoMemory();
    }
    return weights;
}

static PyObject *frame_times(const Plan *plan, const Frames *frames)
{
    Py_buffer out;
    PyObject *times = new_array(plan->empty, &out, frames->count, 0);
    if (!times)
        return NULL;
    fill_times(plan, frames, 0, frames->count, out.buf);
    PyBuffer_Release(&out);
    return times;
}

/* Lay a track in new memory, and perform it. */
static PyObject *lay_and_perform(const Bank *bank, const Plan *plan, const Size *ids, const double *times, Size count,
                                 const Dial *dials, Size dial_count)
{
    const size_t n = (size_t)count + 2;
    double *memory = malloc((3 * n + 1) * sizeof(double) + 2 * n * sizeof(Size) + n);
    if (!memory)
        return PyErr_NoMemory();
    double *bounds = memory, *reach = bounds + n + 1, *moving = reach + n;
    Size *own = (Size *)(moving + n), *rows = own + n;
    Track track;
    int head, tail;
    lay_track(bank, plan, ids, times, count, &track, own, bounds, reach, moving, rows, (Byte *)(rows + n), &head,
              &tail);
    const Frames frames = lay_frames(plan, &track, times[0], times[count], head, tail);
    const Size span[2] = {0, frames.count};
    PyObject *weights = performed(bank, plan, &track, dials, dial_count, &frames, span);
    free(memory);
    PyObject *at = weights ? frame_times(plan, &frames) : NULL;
    PyObject *both = at ? PyTuple_Pack(2, at, weights) : NULL;
    Py_XDECREF(at);
    Py_XDECREF(weights);
    return both;
}

/* utter(bank, plan, ids, times, dials) -> (T,) seconds, (T, P) weights */
static PyObject *utter(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    if (nargs != 5) {
        PyErr_SetString(PyExc_TypeError, "utter(bank, plan, ids, times, dials)");
        return NULL;
    }
    const Bank *bank = PyCapsule_GetPointer(args[0], "lipsync_lang.bank");
    const Plan *plan = bank ? PyCapsule_GetPointer(args[1], "lipsync_lang.plan") : NULL;
    if (!plan || !fits(bank, plan))
        return NULL;
    Views views = {.views = 0};
    PyObject *made = NULL;
    if (PyObject_GetBuffer(args[2], &views.view[0], PyBUF_SIMPLE) < 0)
        return NULL;
    views.views = 1;
    const Size *ids = views.view[0].buf;
    const Size count = views.view[0].len / (Size)sizeof(Size);
    const double *times = keep(&views, args[3], sizeof(double), count + 1, "times");
    if (times && count < 1)
        PyErr_SetString(PyExc_ValueError, "no phonemes");
    else if (times && within(ids, count, bank->phonemes, "ids") && rising(times, count + 1)) {
        Dial *dials;
        const Size dial_count = read_dials(args[4], plan, &dials);
        if (dial_count >= 0) {
            made = lay_and_perform(bank, plan, ids, times, count, dials, dial_count);
            release_dials(dials, dial_count);
        }
    }
    release_views(&views);
    return made;
}

/* weigh(bank, plan, ids, bounds, reach, moving, rows, waived, start, first, count, begin, stop, dials) -> (T, P)
weights of frames begin to stop, as if there were no others */
static PyObject *weigh(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    if (nargs != 14) {
        PyErr_SetString(PyExc_TypeError, "weigh takes 14 arguments");
        return NULL;
    }
    const Bank *bank = PyCapsule_GetPointer(args[0], "lipsync_lang.bank");
    const Plan *plan = bank ? PyCapsule_GetPointer(args[1], "lipsync_lang.plan") : NULL;
    if (!plan || !fits(bank, plan))
        return NULL;
    Frames frames = {PyFloat_AsDouble(args[8]), PyLong_AsSsize_t(args[9]), PyLong_AsSsize_t(args[10])};
    const Size span[2] = {PyLong_AsSsize_t(args[11]), PyLong_AsSsize_t(args[12])};
    if (PyErr_Occurred())
        return NULL;
    if (!(frames.start > -LATEST && frames.start < LATEST) || frames.count < 1 ||
        fabs((double)frames.first) > LATEST * 1e3 || frames.count > (Size)(LATEST * 1e3) ||
        span[0] < 0 || span[1] <= span[0] || span[1] > frames.count) {
        PyErr_SetString(PyExc_ValueError, "frames out of range");
        return NULL;
    }
    Views views = {.views = 0};
    Track track = {0};
    Dial *dials;
    PyObject *made = NULL;
    if (PyObject_GetBuffer(args[2], &views.view[0], PyBUF_SIMPLE) < 0)
        return NULL;
    views.views = 1;
    track.ids = views.view[0].buf;
    const Size n = track.count = views.view[0].len / (Size)sizeof(Size);
    if ((track.bounds = keep(&views, args[3], sizeof(double), n + 1, "bounds")) &&
        (track.reach = keep(&views, args[4], sizeof(double), n, "reach")) &&
        (track.moving = keep(&views, args[5], sizeof(double), n, "moving")) &&
        (track.rows = keep(&views, args[6], sizeof(Size), n - 1, "rows")) &&
        (track.waived = keep(&views, args[7], 1, n, "waived")) && within(track.ids, n, bank->phonemes, "ids") &&
        within(track.rows, n - 1, bank->rows, "rows") && rising(track.bounds, n + 1)) {
        const Size dial_count = read_dials(args[13], plan, &dials);
        if (dial_count >= 0) {
            made = performed(bank, plan, &track, dials, dial_count, &frames, span);
            release_dials(dials, dial_count);
        }
    }
    release_views(&views);
    return made;
}

#define SHORT_NUMBER 32 /* bytes of a number below EXACT, its sign and what ends it */
#define EXACT 1e9       /* scaled numbers below have errors far below NEAR_HALF */
#define NEAR_HALF 1e-4  /* nearer than this to a half, the exact digits decide */

/* Write a number with so many digits after the point, as Python's "%.5f" does; return the end.
NULL, with an exception, if there is no memory. */
static char *write_number(char *at, double value, int digits, double scale)
{
    const double scaled = value * scale, whole = floor(scaled), part = scaled - whole;
    if (!(value >= 0 && scaled < EXACT) || signbit(value) || fabs(part - 0.5) < NEAR_HALF) {
        char *exact = PyOS_double_to_string(value, 'f', digits, 0, NULL);
        if (!exact)
            return NULL;
        const size_t length = strlen(exact);
        memcpy(at, exact, length);
        PyMem_Free(exact);
        return at + length;
    }
    unsigned long long number = (unsigned long long)whole + (part > 0.5);
    char text[SHORT_NUMBER];
    int begin = SHORT_NUMBER;
    for (int count = 0; count <= digits || number; count++) {
        if (count == digits)
            text[--begin] = '.';
        text[--begin] = (char)('0' + number % 10);
        number /= 10;
    }
    memcpy(at, text + begin, (size_t)(SHORT_NUMBER - begin));
    return at + (SHORT_NUMBER - begin);
}

/* The bytes that a number takes at most. */
static size_t room(double value)
{
    return fabs(value) < EXACT ? SHORT_NUMBER : 320 + SHORT_NUMBER;
}

/* rows(columns, table) -> str: a line of each row, with commas; six digits in its first number, five in others */
static PyObject *rows(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    const Size columns = nargs == 2 ? PyLong_AsSsize_t(args[0]) : -1;
    Py_buffer view;
    if (columns < 1) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "rows(columns, table) of at least one column");
        return NULL;
    }
    if (PyObject_GetBuffer(args[1], &view, PyBUF_SIMPLE) < 0)
        return NULL;
    const double *values = view.buf;
    const Size count = view.len / (Size)sizeof(double);
    PyObject *made = NULL;
    if (view.len % (Size)sizeof(double) || count % columns) {
        PyErr_SetString(PyExc_ValueError, "a table of whole rows is needed");
    } else {
        size_t most = 0;
        for (Size i = 0; i < count; i++)
            most += room(values[i]);
        char *text = malloc(most + 1), *at = text;
        if (!text)
            PyErr_NoMemory();
        for (Size i = 0; at && i < count; i++) {
            const int first = i % columns == 0, last = i % columns == columns - 1;
            if ((at = write_number(at, values[i], first ? 6 : 5, first ? 1e6 : 1e5)))
                *at++ = last ? '\n' : ',';
        }
        if (at)
            made = PyUnicode_DecodeASCII(text, at - text, NULL);
        free(text);
    }
    PyBuffer_Release(&view);
    return made;
}

/* look_up(table, labels, both, unit) -> int: number and mark of each label of a tuple, into two rows of an array

The table has them as `number + (mark + 1) * unit`. The answer is the count of labels if some have a mark, and
otherwise 0; it is -1 if one is not in the table, or has the highest number, `unit - 1`, and so none of its own. */
static PyObject *look_up(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    if (nargs != 4 || !PyDict_Check(args[0]) || !PyTuple_Check(args[1])) {
        PyErr_SetString(PyExc_TypeError, "look_up(table, labels, both, unit) of a dictionary and a tuple");
        return NULL;
    }
    const Size count = PyTuple_Size(args[1]), unit = PyLong_AsSsize_t(args[3]);
    Size answer = 0;
    if (PyErr_Occurred())
        return NULL;
    Views views = {.views = 0};
    Size *ids = keep_writable(&views, args[2], sizeof(Size), 2 * count, "ids and marks");
    if (ids && unit < 1)
        PyErr_Format(PyExc_ValueError, "a unit of %zd", unit);
    else if (ids)
        for (Size i = 0, *marks = ids + count; i < count && answer >= 0; i++) {
            PyObject *known = PyDict_GetItemWithError(args[0], PyTuple_GetItem(args[1], i));
            const Size code = known ? PyLong_AsSsize_t(known) : -1;
            ids[i] = code % unit;
            marks[i] = code / unit - 1;
            if (code < 0 || ids[i] == unit - 1)
                answer = -1;
            else if (marks[i] >= 0)
                answer = count;
        }
    release_views(&views);
    return PyErr_Occurred() ? NULL : PyLong_FromSsize_t(answer);
}

/* energies(samples, cuts, sums): the exact sum of the squares of int16 samples before each cut; effort.py */
static PyObject *energies(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    if (nargs != 3) {
        PyErr_SetString(PyExc_TypeError, "energies(samples, cuts, sums)");
        return NULL;
    }
    Views views = {.views = 0};
    const Size length = PyObject_Size(args[0]), count = length < 0 ? -1 : PyObject_Size(args[1]);
    const int16_t *samples = count < 0 ? NULL : keep(&views, args[0], sizeof(int16_t), length, "samples");
    const Size *cuts = samples ? keep(&views, args[1], sizeof(Size), count, "cuts") : NULL;
    int64_t *sums = cuts ? keep_writable(&views, args[2], sizeof(int64_t), count, "sums") : NULL;
    if (sums && within(cuts, count, length + 1, "cuts")) {
        int64_t sum = 0;
        for (Size i = 0, at = 0; i < count; sums[i++] = sum)
            for (; at < cuts[i]; at++)
                sum += (int64_t)samples[at] * samples[at];
    }
    release_views(&views);
    return PyErr_Occurred() ? NULL : Py_NewRef(Py_None);
}

/* ---------------------------------------------------------------- samples of pictures

The modules are those of `render/model`. Here every number is the same to the last bit: each step is taken in the
precision of numpy's, single or double, and in its order. */

#define MIN_RISE 1e-9       /* raster.py */
#define SHADE_STEPS 4096    /* light.py */
#define LONGEST_SIDE 65536  /* samples of a window */
#define MOST_TRIANGLES (1 << 28)
#define MOST_VALUES 16      /* of the look of a triangle */
#define TEXTURED 7          /* values of a look with a texture; 4 are light */
#define SRGB_STEPS 256

typedef unsigned long long Key;

typedef struct {
    Size left, top, right, bottom;
} Window;

/* raster.py: `_whole` */
INLINE Size whole(double value, Size low, Size high)
{
    const double up = ceil(value);
    if (!(up > (double)low)) /* neither for what is not a number */
        return low;
    return up < (double)high ? (Size)up : high;
}

/* raster.py: the slope of `_crossing` */
INLINE double slope(const double *start, const double *stop)
{
    const double rise = stop[1] - start[1];
    return (stop[0] - start[0]) / (rise < MIN_RISE ? 1.0 : rise);
}

/* raster.py: `fill`, of one triangle with three corners and depths */
static void fill_triangle(Key *keys, const Window *box, const double *corners, const double *depth, Key name)
{
    const double *upper = corners, *middle = corners + 2, *lower = corners + 4, *other;
    if (middle[1] < upper[1])
        other = upper, upper = middle, middle = other;
    if (lower[1] < middle[1])
        other = middle, middle = lower, lower = other;
    if (middle[1] < upper[1])
        other = upper, upper = middle, middle = other;
    const double ax = corners[2] - corners[0], ay = corners[3] - corners[1], a = depth[1] - depth[0];
    const double bx = corners[4] - corners[0], by = corners[5] - corners[1], b = depth[2] - depth[0];
    const double area = ax * by - bx * ay, along = (a * by - b * ay) / area, down = (b * ax - a * bx) / area;
    const double base = depth[0] - along * corners[0] - down * corners[1], step = (float)along;
    const double longest = slope(upper, lower), first_half = slope(upper, middle), second = slope(middle, lower);
    const Size bottom = whole(lower[1], box->top, box->bottom);
    for (Size y = whole(upper[1], box->top, box->bottom); y < bottom; y++) {
        const double row = (double)y, one = upper[0] + longest * (row - upper[1]);
        const double two = row >= middle[1] ? middle[0] + second * (row - middle[1])
                                            : upper[0] + first_half * (row - upper[1]);
        const Size left = whole(least(one, two), box->left, box->right);
        const Size right = whole(most(one, two), box->left, box->right);
        const double start = (float)(base + along * (double)left + down * row);
        Key *to = keys + (y - box->top) * (box->right - box->left) + (left - box->left);
        for (Size x = 0; x < right - left; x++) {
            const float near = (float)(start + step * (double)x);
            unsigned int bits;
            memcpy(&bits, &near, sizeof bits);
            const Key key = (Key)bits << 32 | name;
            to[x] = key > to[x] ? key : to[x];
        }
    }
}

/* Read a window from four arguments; 0, with an exception, unless it has room for nothing strange. */
static int read_window(PyObject *const *args, Window *box)
{
    Size sides[4];
    for (int i = 0; i < 4; i++) {
        sides[i] = PyLong_AsSsize_t(args[i]);
        if (sides[i] == -1 && PyErr_Occurred())
            return 0;
        if (sides[i] < 0 || sides[i] > LONGEST_SIDE || (i >= 2 && sides[i] < sides[i - 2])) {
            PyErr_Format(PyExc_ValueError, "a window has no side at %zd", sides[i]);
            return 0;
        }
    }
    *box = (Window){sides[0], sides[1], sides[2], sides[3]};
    return 1;
}

INLINE Size samples_of(const Window *box) { return (box->right - box->left) * (box->bottom - box->top); }

/* fill(keys, left, top, right, bottom, corners, depth, names): triangles into the keys of a window */
static PyObject *fill(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    Views views = {.views = 0};
    Window box;
    if (nargs != 8) {
        PyErr_SetString(PyExc_TypeError, "fill(keys, left, top, right, bottom, corners, depth, names)");
        return NULL;
    }
    const Size count = PyObject_Size(args[7]);
    if (count < 0 || !read_window(args + 1, &box))
        return NULL;
    Key *keys = keep_writable(&views, args[0], sizeof(Key), samples_of(&box), "keys");
    const double *corners = keys ? keep(&views, args[5], sizeof(double), 6 * count, "corners") : NULL;
    const double *depth = corners ? keep(&views, args[6], sizeof(double), 3 * count, "depth") : NULL;
    const Size *names = depth ? keep(&views, args[7], sizeof(Size), count, "names") : NULL;
    if (names) {
        Py_BEGIN_ALLOW_THREADS
        for (Size i = 0; i < count; i++)
            fill_triangle(keys, &box, corners + 6 * i, depth + 3 * i, (unsigned int)(names[i] + 1));
        Py_END_ALLOW_THREADS
    }
    release_views(&views);
    return names ? Py_NewRef(Py_None) : NULL;
}

typedef struct {
    Py_buffer view; /* (height, width, 4) */
    int open;
} Texture;

typedef struct {
    const Size *rank; /* (names,) number among the triangles that are drawn; -1 of others */
    Size names, count, values;
    const float *looks;   /* (3, values, count) */
    const Size *textured; /* (count,) number of a texture; -1 without one */
    Size kinds;
    Texture *textures;    /* (kinds,) */
    const double *linear; /* (SRGB_STEPS,) */
} Surface;

/* scene.py: `Material.texels`, a row or column of a texture, which repeats */
INLINE Size texel_at(float place, Size count)
{
    const float at = floorf(place * (float)count);
    const Size whole = at > -9e18f && at < 9e18f ? (Size)at : PY_SSIZE_T_MIN; /* as numpy converts it */
    return whole % count + (whole % count < 0 ? count : 0);
}

/* picture.py: `_drawn` and `_at`, for the samples of a row */
static void shade_row(const Key *keys, float *light, Size plane, Size width, float left, float row, const Surface *of)
{
    const Size step = of->values * of->count;
    float first[TEXTURED] = {0}, along[TEXTURED] = {0}, down[TEXTURED] = {0};
    const Py_buffer *texture = NULL;
    Size last = -1;
    for (Size x = 0; x < width; x++) {
        const Size name = (Size)(keys[x] & 0xFFFFFFFFu) - 1;
        const Size rank = name >= 0 && name < of->names ? of->rank[name] : -1;
        if (rank < 0 || rank >= of->count)
            continue;
        if (rank != last) {
            texture = of->textured[rank] < 0 ? NULL : &of->textures[of->textured[rank]].view;
            for (int i = 0; i < (texture ? TEXTURED : 4); i++) {
                const float *look = of->looks + i * of->count + rank;
                first[i] = look[0];
                along[i] = look[step];
                down[i] = look[2 * step] * row;
            }
        }
        last = rank;
        const float column = (float)x + left;
        float look[TEXTURED];
        for (int i = 0; i < (texture ? TEXTURED : 4); i++)
            look[i] = first[i] + along[i] * column + down[i];
        if (texture) {
            const Size across = texel_at(look[4] / look[6], texture->shape[1]);
            const Byte *texel = texture->buf;
            texel += 4 * (texel_at(look[5] / look[6], texture->shape[0]) * texture->shape[1] + across);
            for (int i = 0; i < 3; i++)
                look[i] = (float)((double)look[i] * of->linear[texel[i]]);
        }
        for (int i = 0; i < 3; i++)
            light[i * plane + x] = look[i] + look[3];
    }
}

static void release_textures(Surface *of)
{
    for (Size i = 0; of->textures && i < of->kinds; i++)
        if (of->textures[i].open)
            PyBuffer_Release(&of->textures[i].view);
    free(of->textures);
}

/* Read a tuple of textures, with None for materials without one; 0, with an exception, if triangles lack theirs. */
static int read_textures(PyObject *given, Surface *of)
{
    if (!PyTuple_Check(given)) {
        PyErr_SetString(PyExc_TypeError, "textures are a tuple");
        return 0;
    }
    of->kinds = PyTuple_Size(given);
    of->textures = calloc((size_t)of->kinds + 1, sizeof(Texture));
    if (!of->textures) {
        PyErr_NoMemory();
        return 0;
    }
    for (Size i = 0; i < of->kinds; i++) {
        PyObject *item = PyTuple_GetItem(given, i);
        Texture *one = &of->textures[i];
        if (item == Py_None)
            continue;
        if (PyObject_GetBuffer(item, &one->view, PyBUF_ND) < 0)
            return 0;
        one->open = 1;
        const Py_buffer *view = &one->view;
        if (view->ndim != 3 || view->itemsize != 1 || view->shape[2] != 4 || view->len == 0) {
            PyErr_SetString(PyExc_ValueError, "a texture has rows of columns of four bytes");
            return 0;
        }
    }
    for (Size i = 0; i < of->count; i++) {
        const Size number = of->textured[i];
        if (number >= of->kinds || (number >= 0 && (!of->textures[number].open || of->values < TEXTURED))) {
            PyErr_Format(PyExc_ValueError, "no texture %zd", number);
            return 0;
        }
    }
    return 1;
}

/* shade(keys, left, top, right, bottom, light, rank, values, count, looks, textured, textures, linear): light of what
the keys show */
static PyObject *shade(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    Views views = {.views = 0};
    Window box;
    Surface of = {.count = nargs == 13 ? PyLong_AsSsize_t(args[8]) : -1};
    if (of.count < 0 || of.count > MOST_TRIANGLES) {
        if (!PyErr_Occurred())
            PyErr_SetString(PyExc_ValueError, "shade takes 13 arguments: keys, a window, light, rank, values, ...");
        return NULL;
    }
    of.names = PyObject_Size(args[6]);
    of.values = PyLong_AsSsize_t(args[7]);
    if (PyErr_Occurred() || !read_window(args + 1, &box))
        return NULL;
    if (of.values < 4 || of.values > MOST_VALUES) {
        PyErr_Format(PyExc_ValueError, "looks have no %zd values", of.values);
        return NULL;
    }
    const Size plane = samples_of(&box), width = box.right - box.left;
    const Key *keys = keep(&views, args[0], sizeof(Key), plane, "keys");
    float *light = keys ? keep_writable(&views, args[5], sizeof(float), 3 * plane, "light") : NULL;
    of.rank = light ? keep(&views, args[6], sizeof(Size), of.names, "rank") : NULL;
    of.looks = of.rank ? keep(&views, args[9], sizeof(float), 3 * of.values * of.count, "looks") : NULL;
    of.textured = of.looks ? keep(&views, args[10], sizeof(Size), of.count, "textured") : NULL;
    of.linear = of.textured ? keep(&views, args[12], sizeof(double), SRGB_STEPS, "linear") : NULL;
    const int sound = of.linear && read_textures(args[11], &of);
    if (sound) {
        Py_BEGIN_ALLOW_THREADS
        for (Size y = 0; y < box.bottom - box.top; y++)
            shade_row(keys + y * width, light + y * width, plane, width, (float)box.left, (float)(y + box.top), &of);
        Py_END_ALLOW_THREADS
    }
    release_textures(&of);
    release_views(&views);
    return sound ? Py_NewRef(Py_None) : NULL;
}

/* light.py: `encoded`, the step of its table */
INLINE Size shade_step(float light)
{
    const float step = light * (SHADE_STEPS - 1);
    if (!(step > 0))
        return 0;
    return step < SHADE_STEPS - 1 ? (Size)step : SHADE_STEPS - 1;
}

/* picture.py: `_pixels`, for a row of pixels */
INLINE void average_row(const float *light, Size plane, Size width, Size fine, const Byte *shades, Byte *pixels)
{
    for (Size x = 0; x < width / fine; x++)
        for (Size i = 0; i < 3; i++) {
            const float *from = light + i * plane + x * fine;
            float total = from[0];
            for (Size n = 1; n < fine; n++)
                total += from[n];
            for (Size row = 1; row < fine; row++)
                for (Size n = 0; n < fine; n++)
                    total += from[row * width + n];
            pixels[3 * x + i] = shades[shade_step(total / (float)(fine * fine))];
        }
}

/* average(light, width, height, fine, shades, pixels): pixels of the means of fine * fine samples */
static PyObject *average(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    Views views = {.views = 0};
    Size numbers[3];
    if (nargs != 6) {
        PyErr_SetString(PyExc_TypeError, "average(light, width, height, fine, shades, pixels)");
        return NULL;
    }
    for (int i = 0; i < 3; i++) {
        numbers[i] = PyLong_AsSsize_t(args[i + 1]);
        if (numbers[i] == -1 && PyErr_Occurred())
            return NULL;
    }
    const Size width = numbers[0], height = numbers[1], fine = numbers[2];
    if (width < 0 || width > LONGEST_SIDE || height < 0 || height > LONGEST_SIDE || fine < 1 || width % fine ||
        height % fine) {
        PyErr_SetString(PyExc_ValueError, "whole pixels of samples are needed");
        return NULL;
    }
    const Size plane = width * height;
    const float *light = keep(&views, args[0], sizeof(float), 3 * plane, "light");
    const Byte *shades = light ? keep(&views, args[4], 1, SHADE_STEPS, "shades") : NULL;
    Byte *pixels = shades ? keep_writable(&views, args[5], 1, 3 * plane / (fine * fine), "pixels") : NULL;
    if (pixels) {
        Py_BEGIN_ALLOW_THREADS
        for (Size y = 0; y < height / fine; y++) {
            const float *from = light + y * fine * width;
            Byte *to = pixels + 3 * y * (width / fine);
            if (fine == 2) /* a constant, which the compiler unrolls */
                average_row(from, plane, width, 2, shades, to);
            else
                average_row(from, plane, width, fine, shades, to);
        }
        Py_END_ALLOW_THREADS
    }
    const int done = pixels != NULL;
    release_views(&views);
    return done ? Py_NewRef(Py_None) : NULL;
}

static PyMethodDef methods[] = {
    {"look_up", (PyCFunction)(void (*)(void))look_up, METH_FASTCALL, "Look the labels of a line up."},
    {"rows", (PyCFunction)(void (*)(void))rows, METH_FASTCALL, "Write a table of numbers as text."},
    {"energies", (PyCFunction)(void (*)(void))energies, METH_FASTCALL, "Add the squares of samples up."},
    {"fill", (PyCFunction)(void (*)(void))fill, METH_FASTCALL, "Draw triangles into the keys of samples."},
    {"shade", (PyCFunction)(void (*)(void))shade, METH_FASTCALL, "Light the samples that triangles cover."},
    {"average", (PyCFunction)(void (*)(void))average, METH_FASTCALL, "Make pixels of samples."},
    {"bank", make_bank, METH_VARARGS, "Keep the curves of a language and a character."},
    {"plan", make_plan, METH_VARARGS, "Keep what a motion at a frame rate needs."},
    {"utter", (PyCFunction)(void (*)(void))utter, METH_FASTCALL, "Perform phonemes in time."},
    {"weigh", (PyCFunction)(void (*)(void))weigh, METH_FASTCALL, "Perform a track that is laid."},
    {NULL, NULL, 0, NULL},
};

static int tell_interface(PyObject *module) { return PyModule_AddIntConstant(module, "INTERFACE", INTERFACE); }

static PyModuleDef_Slot slots[] = {{Py_mod_exec, tell_interface}, {0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_kernel", "The stages of a performance, and the samples of pictures.", 0, methods, slots, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__kernel(void) { return PyModuleDef_Init(&definition); }
