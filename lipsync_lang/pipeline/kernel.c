/* The stages of a performance, compiled.

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

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__)
#define WIDE_VECTORS __attribute__((target_clones("avx2", "default"))) /* the loader chooses one */
#else
#define WIDE_VECTORS
#endif

#if defined(__GNUC__)
#define PREFETCH(address) __builtin_prefetch(address)
#else
#define PREFETCH(address) ((void)(address))
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

#define INTERFACE 4         /* kernel.py: another number wherever calls or arguments change */
#define RESOLUTION 128      /* tables.py */
#define TOUCH 1e-7          /* warp.py */
#define MARGIN 0.030        /* hold.py */
#define SHORTEST 0.042      /* hold.py */
#define TAPS 3              /* of a kernel, on each side, in one pass over a row */
#define LANES 4             /* poses read at once */
#define SOON 8              /* frames until a row of the curves is read that is fetched into the cache now */
#define CHAINS 10           /* rows whose running minima are computed at once */
#define LATEST 1e9          /* seconds; beyond it frames have no place */
#define MAX_VIEWS 20
#define PI 3.141592653589793
#define PAUSE_SECONDS 0.12  /* gesturing.py, and the next four */
#define PAUSE_SETTLED 0.3
#define MARKED 1000.0
#define VOWEL 2
#define PRIMARY 1
#define DRAWING 0.5         /* placing.py */
#define OPENING 0.9         /* placing.py */
#define SHIFT 0.25          /* laying.py */
#define ROUNDED 1e-9        /* laying.py */
#define MAX_TRIGGERS 64
#define LONGEST 1e6         /* seconds of a line with gestures */

INLINE double least(double a, double b) { return a < b ? a : b; }
INLINE double most(double a, double b) { return a > b ? a : b; }
INLINE Size least_size(Size a, Size b) { return a < b ? a : b; }
INLINE Size most_size(Size a, Size b) { return a > b ? a : b; }

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
enum { POSES, PHONEMES, CONTACTS, EARLY, AHEAD, BINDING, PAIRS, RAMP, WIDE, SHARED, HALO, BLOCK, LEAD, SIZES };
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
    double *curves;  /* (P, stride) */
    double *joined;  /* (stride, P) */
    double *fresh;   /* (EARLY, stride) */
    double *room;    /* (stride,) */
    double *row;     /* (stride + 2 reach,) */
    double *part;    /* (stride, 2) between two rows of the curves */
    double *share;   /* (stride,) of the bigram that begins */
    Size *phoneme;   /* (stride,) */
    Size *ending;    /* (stride,) rows of the curves, of the bigram that ends with the phoneme */
    Size *beginning; /* (stride,) and of the one that begins with it */
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

/* ---------------------------------------------------------------- warp.py, stitch.py */

/* `warp`: the row of the curves before a position in a bigram, and the share of the way to the next. */
INLINE Size row_at(Size row, double position, double *part)
{
    const double steps = least(most(position * RESOLUTION, 0), RESOLUTION - 1e-9);
    Size low = (Size)steps;
    if ((size_t)low >= RESOLUTION)
        low = RESOLUTION - 1;
    *part = steps - (double)low;
    return row * (RESOLUTION + 1) + low;
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

/* `locate` and the positions of `warp`, phoneme by phoneme */
INLINE void locate(const Bank *bank, const Plan *plan, const Track *track, const Frames *frames, Size low, Size width,
                   Scratch *s)
{
    const Size last = track->count - 1;
    Size at = phoneme_at(track, seconds(plan, frames, low) + TOUCH);
    for (Size t = 0; t < width; at++) {
        double boundary[2] = {0, 0};
        Size rows[2] = {0, 0}; /* rest before the first phoneme and after the last */
        for (int side = 0; side < 2; side++) {
            const Size bigram = at - 1 + side;
            if (bigram < 0 || bigram >= last)
                continue;
            rows[side] = track->rows[bigram];
            boundary[side] = plan->flag[LINEAR]
                                 ? track->moving[bigram] / (track->moving[bigram] + track->moving[bigram + 1])
                                 : bank->boundary[rows[side]];
        }
        const double start = track->bounds[at], end = track->bounds[at + 1], moving = track->moving[at];
        const int is_long = moving < track->reach[at];
        for (; t < width; t++) {
            const double time = seconds(plan, frames, low + t);
            if (at < last && end <= time + TOUCH)
                break;
            double passed = time - start, left = end - time;
            if (is_long) {
                passed = least(passed, most(moving / 2, moving - left));
                left = moving - passed;
            }
            const double coming = fabs(passed - moving) <= TOUCH ? 1.0 : most(passed, 0) / moving;
            const double going = fabs(left - moving) <= TOUCH ? 0.0 : 1 - left / moving;
            s->phoneme[t] = at;
            s->share[t] = least(most(going, 0), 1);
            s->ending[t] = row_at(coming <= 1 ? rows[0] : 0, boundary[0] + (1 - boundary[0]) * coming, s->part + 2 * t);
            s->beginning[t] = row_at(going >= 0 ? rows[1] : 0, boundary[1] * going, s->part + 2 * t + 1);
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
    locate(bank, plan, track, frames, low, width, s);
    for (Size t = 0; t < width; t++) {
        const float *ending = bank->curves + s->ending[t] * poses, *beginning = bank->curves + s->beginning[t] * poses;
        const double *part = s->part + 2 * t, share = s->share[t];
        if (t + SOON < width) {
            PREFETCH(bank->curves + s->ending[t + SOON] * poses);
            PREFETCH(bank->curves + s->beginning[t + SOON] * poses);
        }
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
    for (Size p = 0; p < poses; p++) {
        const double *RESTRICT from = s->joined + p;
        double *RESTRICT row = s->curves + p * s->stride;
        for (Size t = 0; t < width; t++)
            row[t] = from[t * poses];
    }
}

/* ---------------------------------------------------------------- levels.py */

/* `scale`: numpy.interp of each level, walked along the frames */
INLINE void scale(const Plan *plan, const Dial *dials, Size dial_count, const Frames *frames, Size low, Size width,
                  Scratch *s)
{
    const Size poses = plan->size[POSES];
    double *RESTRICT level = s->row;
    for (Size d = 0; d < dial_count; d++) {
        const Dial *dial = dials + d;
        const double *at = dial->times, *value = dial->values;
        const Size last = dial->count - 1;
        Size k = -1; /* the last point that is not after the frame */
        for (Size t = 0; t < width; t++) {
            const double time = seconds(plan, frames, low + t);
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
            room[t] = opposed[track->ids[s->phoneme[t]]] ? 0 : most(room[t], 0);
        double *RESTRICT narrowest = s->row;
        memcpy(out, own, (size_t)width * sizeof(double));
        memcpy(narrowest, room, (size_t)width * sizeof(double));
        own[width] = room[width] = 0;
        for (Size far = 1; far <= ahead && far < width && left[far] > 0; far += 2) { /* two, to load less */
            const double *RESTRICT later = own + far, *RESTRICT between = room + far;
            const double one = left[far], two = far < ahead ? left[far + 1] : 0;
            for (Size t = 0; t < width - far; t++) {
                const double nearer = narrowest[t], farther = least(nearer, between[t]);
                out[t] = most(most(out[t], least(one * later[t], nearer)), least(two * later[t + 1], farther));
                narrowest[t] = least(farther, between[t + 1]);
            }
        }
    }
    for (Size r = 0; r < plan->size[EARLY]; r++)
        memcpy(s->curves + plan->early[r] * s->stride, s->fresh + r * s->stride, (size_t)width * sizeof(double));
}

/* ---------------------------------------------------------------- soften.py */

/* `_round`: `reach` is a multiple of TAPS, the half kernel being filled up with zeros */
INLINE void round_off(double *RESTRICT row, Size width, const double *half, Size reach, double *RESTRICT padded)
{
    memset(padded, 0, (size_t)reach * sizeof(double));
    memcpy(padded + reach, row, (size_t)width * sizeof(double));
    memset(padded + reach + width, 0, (size_t)reach * sizeof(double));
    const double *RESTRICT c = padded + reach;
    const double middle = half[0];
    for (Size j = 1; j <= reach; j += TAPS) {
        const double one = half[j], two = half[j + 1], three = half[j + 2];
        if (j == 1)
            for (Size t = 0; t < width; t++)
                row[t] = middle * c[t] + one * (c[t - 1] + c[t + 1]) + two * (c[t - 2] + c[t + 2]) +
                         three * (c[t - 3] + c[t + 3]);
        else
            for (Size t = 0; t < width; t++)
                row[t] += one * (c[t - j] + c[t + j]) + two * (c[t - j - 1] + c[t + j + 1]) +
                          three * (c[t - j - 2] + c[t + j + 2]);
    }
}

/* `soften` */
INLINE void soften(const Plan *plan, const double *kernels, Size reach, Size width, Scratch *s)
{
    for (Size p = 0; reach && p < plan->size[POSES]; p++) {
        const double *half = kernels + p * (reach + 1);
        Size own = reach;
        while (own && half[own] == 0 && half[own - 1] == 0 && half[own - 2] == 0)
            own -= TAPS;
        if (half[0] > 0)
            round_off(s->curves + p * s->stride, width, half, most_size(own, TAPS), s->row);
    }
}

/* ---------------------------------------------------------------- hold.py */

/* `held_frames` and `hold`, over the phonemes near the frames */
INLINE void hold(const Plan *plan, const Track *track, const Frames *frames, Size low, Size width, Scratch *s)
{
    const Size poses = plan->size[POSES], n = track->count;
    const double fps = plan->number[FPS], reach = most(SHORTEST, 1 / fps) / 2;
    const double origin = frames->start + (double)frames->first / fps;
    const Size begin = phoneme_at(track, seconds(plan, frames, low) - reach - 2 / fps);
    const Size stop = phoneme_at(track, seconds(plan, frames, low + width) + reach + 2 / fps) + 1;
    for (Size c = 0; c < plan->size[CONTACTS]; c++) {
        const Byte *demanding = plan->demands + c * plan->size[PHONEMES];
        const double *floors = plan->levels + c * 2 * poses, *ceilings = floors + poses;
        for (Size at = begin; at < stop; at++) {
            if (!demanding[track->ids[at]] || track->waived[at])
                continue;
            const Size before = at ? at - 1 : n - 1, after = at + 1 < n ? at + 1 : at;
            const int since = demanding[track->ids[before]] && !track->waived[before];
            const int on = after != at && demanding[track->ids[after]] && !track->waived[after];
            const double start = track->bounds[at], end = track->bounds[at + 1], middle = (start + end) / 2;
            const double from = least(since ? start : start + MARGIN, middle - reach);
            const double to = most(on ? end : end - MARGIN, middle + reach);
            const Size one = most_size((Size)ceil((from - origin) * fps - 1e-6) - low, 0);
            const Size past = least_size((Size)floor((to - origin) * fps + 1e-6) + 1 - low, width);
            for (Size p = 0; p < poses; p++) {
                double *RESTRICT row = s->curves + p * s->stride;
                for (Size t = one; t < past; t++)
                    row[t] = least(most(row[t], floors[p]), ceilings[p]);
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
    for (Size p = 0; p < poses; p++) {
        double *RESTRICT row = s->curves + p * s->stride;
        const double top = plan->tops[p];
        if (plan->upper[p])
            flip(row, width);
        if (plan->flag[CLIP_SLOW])
            for (Size t = 0; t < width; t++)
                row[t] = least(most(row[t], 0), top);
    }
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

INLINE void clip(const Plan *plan, const double *tops, int below, Size width, Scratch *s)
{
    for (Size p = 0; p < plan->size[POSES]; p++) {
        double *RESTRICT row = s->curves + p * s->stride;
        const double top = tops ? tops[p] : 1;
        for (Size t = 0; t < width; t++)
            row[t] = least(below ? most(row[t], 0) : row[t], top);
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
        scale(plan, dials, dial_count, frames, low, width, s);
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
    const double *RESTRICT made = s->curves + begin - low;
    Size p = 0;
    for (; p + LANES <= poses; p += LANES, made += LANES * s->stride)
        for (Size t = 0; t < stop - begin; t++)
            for (Size i = 0; i < LANES; i++)
                out[t * poses + p + i] = made[i * s->stride + t];
    for (; p < poses; p++, made += s->stride)
        for (Size t = 0; t < stop - begin; t++)
            out[t * poses + p] = made[t];
}

/* `Performance.last` on a span of frames; returns -1 where there is no memory */
static int run_all(const Bank *bank, const Plan *plan, const Track *track, const Dial *dials, Size dial_count,
                   const Frames *frames, const Size *span, double *out)
{
    const Size poses = plan->size[POSES], block = plan->size[BLOCK], early = plan->size[EARLY];
    const Size stride = least_size(span[1] - span[0], block + 2 * plan->size[HALO]) + 8;
    const Size reach = most_size(plan->size[WIDE], plan->size[SHARED]);
    const size_t doubles = (size_t)stride * (size_t)(2 * poses + early + 5) + 2 * (size_t)reach;
    double *memory = malloc(doubles * sizeof(double) + 3 * (size_t)stride * sizeof(Size));
    if (!memory)
        return -1;
    Scratch s = {.curves = memory, .stride = stride};
    s.joined = s.curves + poses * stride;
    s.fresh = s.joined + poses * stride;
    s.room = s.fresh + early * stride;
    s.part = s.room + stride;
    s.share = s.part + 2 * stride;
    s.row = s.share + stride;
    s.phoneme = (Size *)(memory + doubles);
    s.ending = s.phoneme + stride;
    s.beginning = s.ending + stride;
    for (Size begin = span[0]; begin < span[1]; begin += block) {
        const Size stop = least_size(begin + block, span[1]);
        double *here = out + (begin - span[0]) * poses;
        run_block(bank, plan, track, dials, dial_count, frames, span, begin, stop, &s, here);
    }
    free(memory);
    return 0;
}

/* ---------------------------------------------------------------- placing.py, laying.py, gesturing.py

Gestures have the same bytes as those of the modules, for a line whose voice scales none. */

enum { PAUSE, PHRASE_END, STRESS, EMPHASIS, TAKEN }; /* triggers that are found here; words have others */

typedef struct {
    Size before, rows, moves; /* frames before its peak, all frames, and poses */
    const Size *pose;         /* (moves,) */
    const double *amount;     /* (rows, moves) */
    const Byte *on, *at;      /* (triggers,) */
    double share, lead, rates[2], room, spread, peak;
} Gesture;

typedef struct {
    Views views;
    PyObject *empty; /* numpy.empty */
    Size count, poses, triggers, phonemes, silence;
    double fps;
    const Size *manners;               /* (phonemes,) */
    const double *low, *high, *step;   /* (poses,) */
    Gesture *gesture;                  /* (count,) */
} Gestures;

typedef struct {
    double start, end; /* of the frames */
    Size frames;
    Size sounds, labels, words;
    const Size *ids;         /* (sounds,) */
    const double *bounds;    /* (sounds + 1,) */
    const Size *source;      /* (sounds,) */
    const double *times;     /* (labels + 1,) */
    const Size *stresses;    /* (labels,), or NULL without marks */
    const Size *raised;      /* (raised_count, 2) labels of words with emphasis: first and stop */
    const Size *said;        /* (said_count, 2) trigger of a word, and its first label */
    Size raised_count, said_count;
    double *starts;          /* (words,) */
    uint32_t *seeds;         /* (words + 1,) */
    double *phrases;         /* (phrase_count, 2) */
    Size phrase_count;
    double *facts[MAX_TRIGGERS];
    Size fact_count[MAX_TRIGGERS];
} Line;

typedef struct {
    Size *first; /* (count,) first frame of each gesture, those of a kind together */
    Size count, room;
} Placed;

/* `seed_after`: CRC-32 goes on with the bytes of a text. */
static uint32_t seed_after(uint32_t seed, const char *text, Size length)
{
    static const uint32_t table[16] = {
        0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c,
    };
    seed = ~seed;
    for (Size i = 0; i < length; i++) {
        seed ^= (Byte)text[i];
        seed = table[seed & 15] ^ seed >> 4;
        seed = table[seed & 15] ^ seed >> 4;
    }
    return ~seed;
}

INLINE double uniform(uint32_t seed, uint32_t salt)
{
    uint32_t bits = seed + 0x9E3779B1u * (salt + 1);
    bits = (bits ^ bits >> 16) * 0x85EBCA6Bu;
    bits = (bits ^ bits >> 13) * 0xC2B2AE35u;
    return ((bits ^ bits >> 16) + 0.5) / 4294967296.0;
}

static double gap(uint32_t seed, uint32_t salt, double spread, double shift)
{
    const double radius = sqrt(-2 * log(uniform(seed, salt)));
    const double normal = radius * cos(2 * PI * uniform(seed, salt + 31));
    return exp(spread * (normal + shift));
}

/* `bisect_left` of rising numbers. */
static Size place_of(const double *numbers, Size count, double wanted)
{
    Size low = 0;
    while (low < count) {
        const Size middle = low + (count - low) / 2;
        if (numbers[middle] < wanted)
            low = middle + 1;
        else
            count = middle;
    }
    return low;
}

static uint32_t seed_at(const Line *line, double time)
{
    Size at = place_of(line->starts, line->words, time += 1e-9);
    while (at < line->words && line->starts[at] <= time)
        at++;
    return line->seeds[at];
}

INLINE void add_fact(Line *line, Size trigger, double time) { line->facts[trigger][line->fact_count[trigger]++] = time; }

static void add_phrase(Line *line, double begin, double end)
{
    if (!(end > begin))
        return;
    line->phrases[2 * line->phrase_count] = begin;
    line->phrases[2 * line->phrase_count++ + 1] = end;
    add_fact(line, PHRASE_END, end);
}

/* `_phrases`, and the facts around them. */
static void take_pauses(const Gestures *own, Line *line)
{
    double edge = line->bounds[0];
    for (Size i = 0; i < line->sounds; i++) {
        if (line->ids[i] != own->silence)
            continue;
        const double begin = line->bounds[i];
        double end = line->bounds[i + 1];
        while (i + 1 < line->sounds && (line->ids[i + 1] == own->silence || line->bounds[i + 2] == end))
            end = line->bounds[++i + 1];
        if (!(end - begin >= PAUSE_SECONDS))
            continue;
        add_phrase(line, edge, begin);
        add_fact(line, PAUSE, least((begin + end) / 2, begin + PAUSE_SETTLED));
        edge = end;
    }
    add_phrase(line, edge, line->bounds[line->sounds]);
}

/* `_vowel_facts` without sound. */
static void take_vowels(const Gestures *own, Line *line, Size *manners, double *begins, double *rises)
{
    Size count = 0, word = 0;
    if (!line->stresses) {
        for (Size label = 0; label < line->labels; label++)
            manners[label] = own->manners[0];
        for (Size i = line->sounds; i--;) /* backwards, so that the first sound of a label stays */
            manners[line->source[i]] = own->manners[line->ids[i]];
    }
    for (Size label = 0; label < line->labels; label++) {
        if (line->stresses ? line->stresses[label] != PRIMARY : manners[label] != VOWEL)
            continue;
        while (word < line->raised_count && line->raised[2 * word + 1] <= label)
            word++;
        begins[count] = line->times[label];
        rises[count] = line->times[label + 1] - line->times[label];
        if (word < line->raised_count && line->raised[2 * word] <= label)
            rises[count] += MARKED;
        if (line->stresses)
            add_fact(line, STRESS, begins[count]);
        count++;
    }
    for (Size i = 0; i < count; i++) { /* `stand_out` */
        Size before = i, after = i + 1;
        while (before && begins[before - 1] >= begins[i] - DRAWING && rises[before - 1] < rises[i])
            before--;
        if (before && begins[before - 1] >= begins[i] - DRAWING)
            continue;
        while (after < count && begins[after] <= begins[i] + DRAWING && rises[after] <= rises[i])
            after++;
        if (after == count || begins[after] > begins[i] + DRAWING)
            add_fact(line, EMPHASIS, begins[i]);
    }
}

/* `fitted`; -1 without memory. */
static int add_placed(const Gestures *own, const Gesture *one, const Line *line, double begin, Placed *placed)
{
    const Size asked = (Size)rint((begin + one->peak - line->start) * own->fps) - one->before;
    const Size first = least_size(most_size(asked, 1), line->frames - 1 - one->rows);
    if (first < 1 || fabs((double)(first - asked)) > SHIFT * own->fps)
        return 0;
    if (placed->count == placed->room) {
        const Size room = 2 * placed->room + 64;
        Size *more = realloc(placed->first, (size_t)room * sizeof(Size));
        if (!more)
            return -1;
        placed->first = more;
        placed->room = room;
    }
    placed->first[placed->count++] = first;
    return 0;
}

/* `placing`: of a time; -1 without memory. */
INLINE int place_at(const Gestures *own, const Gesture *one, const Line *line, double time, double *free_from,
                    Placed *placed)
{
    const double begin = time - one->lead;
    if (begin < *free_from)
        return 0;
    *free_from = begin + one->room;
    return add_placed(own, one, line, begin, placed);
}

/* `_on_facts`; -1 without memory. */
static int place_on_facts(const Gestures *own, Size number, const Line *line, Placed *placed)
{
    const Gesture *one = own->gesture + number;
    Size next[MAX_TRIGGERS] = {0};
    double free_from = -INFINITY;
    for (;;) {
        Size soonest = -1;
        double time = 0;
        for (Size k = 0; k < own->triggers; k++)
            if (one->on[k] && next[k] < line->fact_count[k] && (soonest < 0 || line->facts[k][next[k]] < time)) {
                soonest = k;
                time = line->facts[k][next[k]];
            }
        if (soonest < 0)
            return 0;
        next[soonest]++;
        if ((one->share >= 1 || uniform(seed_at(line, time), (uint32_t)number) < one->share) &&
            place_at(own, one, line, time, &free_from, placed) < 0)
            return -1;
    }
}

/* `_by_itself`; -1 without memory. */
static int place_by_itself(const Gestures *own, Size number, const Line *line, Placed *placed)
{
    const Gesture *one = own->gesture + number;
    const double spread = one->spread;
    uint32_t salt = 2 * (uint32_t)number;
    const uint32_t seed = seed_at(line, line->start + OPENING);
    double passed = uniform(seed, salt + 97) * gap(seed, salt, spread, spread / 2);
    double at = line->start, clock = 0, drawn_from = at, free_from = -INFINITY;
    Size begun = 0;
    while (at < line->end) {
        while (begun < line->phrase_count && line->phrases[2 * begun] <= at)
            begun++;
        const int speaking = begun && at < line->phrases[2 * begun - 1];
        const double until = speaking ? line->phrases[2 * begun - 1]
                             : begun < line->phrase_count ? line->phrases[2 * begun] : line->end;
        const double rate = one->rates[!speaking];
        const double time = rate > 0 ? at + (passed - clock) / rate : INFINITY;
        if (time >= until) {
            clock += (until - at) * rate;
            at = until;
            continue;
        }
        double found = time, distance = INFINITY;
        for (Size k = 0; k < own->triggers; k++) {
            const double *facts = line->facts[k];
            Size i = one->at[k] ? place_of(facts, line->fact_count[k], time - DRAWING) : line->fact_count[k];
            for (; i < line->fact_count[k] && facts[i] <= time + DRAWING; i++) {
                const double far = fabs(facts[i] - time);
                if (facts[i] >= drawn_from && (far < distance || (far == distance && facts[i] < found))) {
                    found = facts[i];
                    distance = far;
                }
            }
        }
        if (place_at(own, one, line, found, &free_from, placed) < 0)
            return -1;
        drawn_from = most(drawn_from, found + one->room);
        salt += 1000;
        passed += gap(seed_at(line, time), salt, spread, -spread / 2);
    }
    return 0;
}

/* `_below` for a row and its steps; `sign` -1 is for the curve's negative. */
static void slow_below(const double *row, Size width, double step, double sign, double *out)
{
    double lowest = INFINITY;
    for (Size t = 0; t < width; t++) {
        const double slope = (double)t * step;
        lowest = least(lowest, sign * row[t] - slope);
        out[t] = lowest + 2 * slope;
    }
    lowest = INFINITY;
    for (Size t = width; t--;) {
        lowest = least(lowest, out[t]);
        out[t] = least(lowest - (double)t * step, sign * row[t]);
    }
}

/* `guard` for a column of the whole line; `memory` has 3 times as many numbers as it has frames. */
static void guard(const Gestures *own, Size pose, double *column, Size stride, Size frames, double *memory)
{
    const double low = own->low[pose], high = own->high[pose], step = own->step[pose];
    double *bound = memory, *below = bound + frames, *above = below + frames;
    for (Size t = 0; t < frames; t++)
        bound[t] = least(most(column[t * stride], low), high);
    slow_below(bound, frames, step, 1, below);
    slow_below(bound, frames, step, -1, above);
    for (Size t = 0; t < frames; t++) {
        const double ramp = least((double)t * step, (double)(frames - 1 - t) * step);
        const double slow = (below[t] - above[t]) / 2;
        const double kept = least(most(slow, most(-ramp, low)), least(ramp, high));
        if (!(fabs(kept - column[t * stride]) < ROUNDED))
            column[t * stride] = kept;
    }
}

/* `lay` beside the weights of speech in `out`; `ends` are the ends of each kind in `placed`. */
static void lay_gestures(const Gestures *own, const double *scales, const Line *line, const Placed *placed,
                         Size *next, const Size *ends, Size *past, Byte *guarded, double *memory, double *out,
                         Size stride)
{
    double *curves = out + stride - own->poses;
    for (;;) { /* in order of their first frames, of equals in the order of the pose set */
        Size number = -1, first = 0;
        for (Size k = 0; k < own->count; k++)
            if (next[k] < ends[k] && (number < 0 || placed->first[next[k]] < first)) {
                number = k;
                first = placed->first[next[k]];
            }
        if (number < 0)
            break;
        next[number]++;
        const Gesture *one = own->gesture + number;
        const double height = scales[number];
        for (Size m = 0; m < one->moves; m++) {
            const Size pose = one->pose[m];
            guarded[pose] |= height > 1 || first < past[pose]; /* `past` is one more there: 0 is none */
            past[pose] = most_size(past[pose], first + one->rows + 1);
            double *here = curves + first * stride + pose;
            for (Size row = 0; row < one->rows; row++)
                here[row * stride] += height * one->amount[row * one->moves + m];
        }
    }
    for (Size pose = 0; pose < own->poses; pose++)
        if (guarded[pose])
            guard(own, pose, curves + pose, stride, line->frames, memory);
}

/* Place and lay the gestures of a line; -1 without memory. */
static int move_face(const Gestures *own, const double *scales, Line *line, double *out, Size stride)
{
    const Size n = line->labels, m = line->sounds, others = own->triggers - TAKEN;
    const size_t doubles = (size_t)(4 * (m + 2) + 4 * n + others * line->said_count + 3 * line->frames);
    const size_t sizes = (size_t)(n + 2 * own->count + own->poses);
    double *memory = malloc(doubles * sizeof(double) + sizes * sizeof(Size) + (size_t)own->poses);
    if (!memory)
        return -1;
    double *end = line->phrases = memory;
    end += 2 * (m + 2);
    const Size room[TAKEN] = {m + 2, m + 2, n, n};
    for (Size k = 0; k < own->triggers; k++) {
        line->facts[k] = end;
        end += k < TAKEN ? room[k] : line->said_count;
    }
    double *begins = end, *rises = begins + n, *rows = rises + n;
    Size *manners = (Size *)(memory + doubles), *next = manners + n, *ends = next + own->count;
    Size *past = ends + own->count;
    Byte *guarded = (Byte *)(past + own->poses);
    memset(past, 0, (size_t)own->poses * sizeof(Size));
    memset(guarded, 0, (size_t)own->poses);
    take_pauses(own, line);
    take_vowels(own, line, manners, begins, rises);
    for (Size i = 0; i < line->said_count; i++)
        add_fact(line, line->said[2 * i], line->times[line->said[2 * i + 1]]);
    Placed placed = {NULL, 0, 0};
    int done = 0;
    for (Size k = 0; k < own->count && done == 0; k++) {
        const Byte *on = own->gesture[k].on;
        next[k] = placed.count;
        if (scales[k] > 0)
            done = memchr(on, 1, (size_t)own->triggers) ? place_on_facts(own, k, line, &placed)
                                                        : place_by_itself(own, k, line, &placed);
        ends[k] = placed.count;
    }
    if (done == 0)
        lay_gestures(own, scales, line, &placed, next, ends, past, guarded, rows, out, stride);
    free(placed.first);
    free(memory);
    return done;
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
    if (!PyArg_ParseTuple(args, "OOOOOOOOOOOOOOOOOO", &plan->empty, &a[0], &a[1], &a[2], &a[3], &a[4], &a[5], &a[6],
                          &a[7], &a[8], &a[9], &a[10], &a[11], &a[12], &a[13], &a[14], &a[15], &a[16])) {
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
        !(plan->wide = keep(v, a[16], sizeof(double), poses * (n[WIDE] + n[SHARED] + 2), "kernels")))
        goto fail;
    plan->shared = plan->wide + poses * (n[WIDE] + 1);
    if (!within(plan->early, n[EARLY], poses, "early") || !within(plan->low, n[BINDING], poses, "low") ||
        !within(plan->at_most, 2 * n[PAIRS], poses, "at_most"))
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
    double *at = out.buf;
    for (Size t = 0; t < frames->count; t++)
        at[t] = seconds(plan, frames, t);
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

static void discard_gestures(Gestures *own)
{
    release_views(&own->views);
    Py_XDECREF(own->empty);
    PyMem_Free(own->gesture);
    PyMem_Free(own);
}

static void free_gestures(PyObject *capsule)
{
    discard_gestures(PyCapsule_GetPointer(capsule, "lipsync_lang.pipeline.gestures"));
}

/* Spread the arrays over the gestures; 0 with an exception where a number is out of range. */
static int spread_gestures(Gestures *own, const Size *spans, const double *numbers, const Byte *on, const Byte *at,
                           const Size *moved, Size moved_count, const double *amounts, Size amount_count)
{
    for (Size k = 0; k < own->count; k++) {
        Gesture *one = own->gesture + k;
        one->before = *spans++;
        one->rows = *spans++;
        one->moves = *spans++;
        one->pose = moved;
        one->amount = amounts;
        one->on = on + k * own->triggers;
        one->at = at + k * own->triggers;
        int sound = one->moves > 0 && one->moves <= moved_count && one->before >= 0 && one->before < one->rows &&
                    one->rows <= amount_count / one->moves;
        double *const fields[] = {&one->share, &one->lead, &one->rates[0], &one->rates[1],
                                  &one->room,  &one->spread, &one->peak};
        for (int i = 0; i < 7; i++) {
            *fields[i] = *numbers++;
            sound &= fabs(*fields[i]) <= LATEST;
        }
        if (!sound || one->rates[0] < 0 || one->rates[0] > 4 || one->rates[1] < 0 || one->rates[1] > 4 ||
            one->spread < 0 || one->spread > 2 || !(one->room > 0)) {
            PyErr_Format(PyExc_ValueError, "gesture %zd is out of range", k);
            return 0;
        }
        moved += one->moves;
        moved_count -= one->moves;
        amounts += one->moves * one->rows;
        amount_count -= one->moves * one->rows;
    }
    if (moved_count || amount_count)
        PyErr_SetString(PyExc_ValueError, "poses or amounts of no gesture");
    return !moved_count && !amount_count;
}

/* gestures(empty, count, poses, triggers, phonemes, silence, moved, amounts, fps, arrays) -> what `gesture` needs */
static PyObject *make_gestures(PyObject *module, PyObject *args)
{
    PyObject *a[8];
    Size moved_count, amount_count;
    Gestures *own = PyMem_Calloc(1, sizeof(Gestures));
    (void)module;
    if (!own)
        return PyErr_NoMemory();
    if (!PyArg_ParseTuple(args, "OnnnnnnndOOOOOOOO", &own->empty, &own->count, &own->poses, &own->triggers,
                          &own->phonemes, &own->silence, &moved_count, &amount_count, &own->fps, &a[0], &a[1], &a[2],
                          &a[3], &a[4], &a[5], &a[6], &a[7])) {
        own->empty = NULL;
        goto fail;
    }
    Py_INCREF(own->empty);
    if (own->count < 0 || own->count > 0xffff || own->poses < 1 || own->poses > 0xffff || own->triggers < TAKEN ||
        own->triggers > MAX_TRIGGERS || own->phonemes < 1 || own->phonemes > 0xffff || moved_count < 0 ||
        moved_count > 0xffffff || amount_count < 0 || amount_count > PY_SSIZE_T_MAX / 16 ||
        !(own->fps > 1e-3 && own->fps < 1e6)) {
        PyErr_SetString(PyExc_ValueError, "gestures without poses, triggers, phonemes or frames");
        goto fail;
    }
    Views *v = &own->views;
    const Size count = own->count, poses = own->poses;
    const Size *spans, *moved;
    const double *numbers, *amounts;
    const Byte *on, *at;
    if (!(own->manners = keep(v, a[0], sizeof(Size), own->phonemes, "manners")) ||
        !(own->low = keep(v, a[1], sizeof(double), 3 * poses, "bounds")) ||
        !(spans = keep(v, a[2], sizeof(Size), 3 * count, "spans")) ||
        !(numbers = keep(v, a[3], sizeof(double), 7 * count, "numbers")) ||
        !(on = keep(v, a[4], 1, count * own->triggers, "on")) || !(at = keep(v, a[5], 1, count * own->triggers, "at")) ||
        !(moved = keep(v, a[6], sizeof(Size), moved_count, "moved")) ||
        !(amounts = keep(v, a[7], sizeof(double), amount_count, "amounts")) ||
        !within(moved, moved_count, poses, "moved") || !within(&own->silence, 1, own->phonemes, "silence"))
        goto fail;
    own->high = own->low + poses;
    own->step = own->high + poses;
    own->gesture = PyMem_Calloc((size_t)count + 1, sizeof(Gesture));
    if (!own->gesture) {
        PyErr_NoMemory();
        goto fail;
    }
    if (!spread_gestures(own, spans, numbers, on, at, moved, moved_count, amounts, amount_count))
        goto fail;
    PyObject *capsule = PyCapsule_New(own, "lipsync_lang.pipeline.gestures", free_gestures);
    if (capsule)
        return capsule;
fail:
    discard_gestures(own);
    return NULL;
}

/* Count the items of a kept array that may have any number of them; -1 with an exception. */
static Size keep_any(Views *views, PyObject *array, Size item, const void **items)
{
    Py_buffer *view = &views->view[views->views];
    if (PyObject_GetBuffer(array, view, PyBUF_SIMPLE) < 0)
        return -1;
    views->views++;
    *items = view->buf;
    if (view->len % item == 0)
        return view->len / item;
    PyErr_Format(PyExc_ValueError, "%zd bytes for items of %zd", view->len, item);
    return -1;
}

/* Number the words up to each of a tuple of texts; 0 with an exception. */
static int read_texts(PyObject *texts, Size count, uint32_t *seeds)
{
    seeds[0] = 0;
    for (Size i = 0; i < count; i++) {
        PyObject *text = PyTuple_GetItem(texts, i), *bytes = NULL;
        Size length;
        const char *held = text && PyUnicode_Check(text) ? PyUnicode_AsUTF8AndSize(text, &length) : NULL;
        if (!held) {
            PyErr_Clear(); /* half of a pair has no UTF-8 */
            bytes = text ? PyUnicode_AsEncodedString(text, "utf-8", "surrogatepass") : NULL;
            if (!bytes || PyBytes_AsStringAndSize(bytes, (char **)&held, &length) < 0) {
                Py_XDECREF(bytes);
                return 0;
            }
        }
        seeds[i + 1] = seed_after(seeds[i], held, length);
        Py_XDECREF(bytes);
    }
    return 1;
}

/* Place and lay the gestures of a line beside its (T, P) weights: (T, P + G) as a new array. */
static PyObject *beside(const Gestures *own, const double *scales, Line *line, const double *weights, Size spoken)
{
    Py_buffer out;
    int done;
    const Size width = spoken + own->poses;
    PyObject *array = new_array(own->empty, &out, line->frames, width);
    if (!array)
        return NULL;
    Py_BEGIN_ALLOW_THREADS
    double *row = out.buf;
    for (Size t = 0; t < line->frames; t++, row += width) {
        memcpy(row, weights + t * spoken, (size_t)spoken * sizeof(double));
        memset(row + spoken, 0, (size_t)own->poses * sizeof(double));
    }
    done = move_face(own, scales, line, out.buf, width);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&out);
    if (done < 0) {
        Py_DECREF(array);
        return PyErr_NoMemory();
    }
    return array;
}

/* Take in words and labels, and call `beside`; `firsts` is NULL where labels stand for words. */
static PyObject *with_texts(const Gestures *own, const double *scales, Line *line, const double *weights, Size spoken,
                            PyObject *texts, const Size *firsts)
{
    const size_t count = (size_t)line->words;
    double *memory = malloc(count * sizeof(double) + (count + 1) * sizeof(uint32_t));
    if (!memory)
        return PyErr_NoMemory();
    line->starts = memory;
    line->seeds = (uint32_t *)(memory + count);
    for (Size i = 0; i < line->words; i++)
        memory[i] = line->times[firsts ? firsts[i] : i];
    PyObject *made = read_texts(texts, line->words, line->seeds) ? beside(own, scales, line, weights, spoken) : NULL;
    free(memory);
    return made;
}

/* gesture(gestures, weights, scales, start, end, ids, bounds, source, stresses, times, texts, firsts, raised, said)
-> (T, P + G) weights; start and end are the seconds of the frames */
static PyObject *gesture(PyObject *module, PyObject *const *args, Py_ssize_t nargs)
{
    (void)module;
    if (nargs != 14) {
        PyErr_SetString(PyExc_TypeError, "gesture takes 14 arguments");
        return NULL;
    }
    const Gestures *own = PyCapsule_GetPointer(args[0], "lipsync_lang.pipeline.gestures");
    if (!own)
        return NULL;
    Line line = {.start = PyFloat_AsDouble(args[3]), .end = PyFloat_AsDouble(args[4])};
    if (PyErr_Occurred())
        return NULL;
    Views views = {.views = 0};
    PyObject *made = NULL;
    const void *found[5];
    Py_buffer *spoken = &views.view[0];
    if (PyObject_GetBuffer(args[1], spoken, PyBUF_ND) < 0)
        return NULL;
    views.views = 1;
    if (spoken->ndim != 2 || spoken->shape[0] < 1 || spoken->itemsize != sizeof(double) ||
        spoken->shape[1] < 1 || spoken->shape[1] > 0xffff ||
        !(line.start > -LATEST && line.end - line.start >= 0 && line.end - line.start < LONGEST) ||
        !PyTuple_Check(args[10])) {
        PyErr_SetString(PyExc_ValueError, "weights, frames or texts out of range");
        goto done;
    }
    line.frames = spoken->shape[0];
    line.words = PyTuple_Size(args[10]);
    const double *scales = keep(&views, args[2], sizeof(double), own->count, "scales");
    const Size times = scales ? keep_any(&views, args[9], sizeof(double), &found[0]) : -1;
    const Size sounds = times < 0 ? -1 : keep_any(&views, args[5], sizeof(Size), &found[1]);
    const Size raised = sounds < 0 ? -1 : keep_any(&views, args[12], 2 * sizeof(Size), &found[2]);
    const Size said = raised < 0 ? -1 : keep_any(&views, args[13], 2 * sizeof(Size), &found[3]);
    const Size firsts = said < 0 ? -1 : keep_any(&views, args[11], sizeof(Size), &found[4]);
    if (firsts < 0)
        goto done;
    line.labels = times - 1;
    line.sounds = sounds;
    line.raised_count = raised;
    line.said_count = said;
    line.times = found[0];
    line.ids = found[1];
    line.raised = found[2];
    line.said = found[3];
    const Size *first = firsts ? found[4] : NULL;
    int sound = times > 1 && sounds > 0 && line.words == (firsts ? firsts : line.labels);
    for (Size k = 0; k < own->count; k++)
        sound &= scales[k] >= 0 && scales[k] <= 1e4;
    for (Size i = 0; sound && i < said; i++)
        sound &= line.said[2 * i] >= TAKEN && line.said[2 * i] < own->triggers && line.said[2 * i + 1] >= 0 &&
                 line.said[2 * i + 1] < line.labels;
    if (!sound) {
        PyErr_SetString(PyExc_ValueError, "scales, labels, sounds or words out of range");
        goto done;
    }
    if (!(line.bounds = keep(&views, args[6], sizeof(double), sounds + 1, "bounds")) ||
        !(line.source = keep(&views, args[7], sizeof(Size), sounds, "source")) ||
        !within(line.ids, sounds, own->phonemes, "ids") || !within(line.source, sounds, line.labels, "source") ||
        !within(first, firsts, line.labels, "firsts") || !rising(line.times, times) || !rising(line.bounds, sounds + 1))
        goto done;
    const Size marks = keep_any(&views, args[8], sizeof(Size), &found[0]);
    if (marks > 0 && marks != line.labels)
        PyErr_SetString(PyExc_ValueError, "stresses of other labels");
    else if (marks >= 0) {
        line.stresses = marks ? found[0] : NULL;
        made = with_texts(own, scales, &line, spoken->buf, spoken->shape[1], args[10], first);
    }
done:
    release_views(&views);
    return made;
}

static PyMethodDef methods[] = {
    {"bank", make_bank, METH_VARARGS, "Keep the curves of a language and a character."},
    {"plan", make_plan, METH_VARARGS, "Keep what a motion at a frame rate needs."},
    {"utter", (PyCFunction)(void (*)(void))utter, METH_FASTCALL, "Perform phonemes in time."},
    {"weigh", (PyCFunction)(void (*)(void))weigh, METH_FASTCALL, "Perform a track that is laid."},
    {"gestures", make_gestures, METH_VARARGS, "Keep the gestures of a pose set at a frame rate."},
    {"gesture", (PyCFunction)(void (*)(void))gesture, METH_FASTCALL, "Add the gestures of a line to its weights."},
    {NULL, NULL, 0, NULL},
};

static int tell_interface(PyObject *module) { return PyModule_AddIntConstant(module, "INTERFACE", INTERFACE); }

static PyModuleDef_Slot slots[] = {{Py_mod_exec, tell_interface}, {0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_kernel", "The stages of a performance, compiled.", 0, methods, slots, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__kernel(void) { return PyModuleDef_Init(&definition); }
