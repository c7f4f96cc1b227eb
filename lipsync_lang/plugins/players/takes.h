/* Player of archives of takes (.takes): one header, C99 and C++, the standard library, no heap.
 *
 *   takes_archive archive;              the bytes stay yours: map the file, or read it
 *   takes_player anna;                  one for each character
 *   if (takes_open(&archive, bytes, size) != TAKES_OK) ...
 *   takes_start(&anna, &archive);
 *   takes_play(&anna, "english/intro_001", 0.1);
 *   takes_advance(&anna, 1.0 / 60);     once in each frame; then use anna.weights
 *
 * Times are seconds on the timeline of a line, whose sound starts at player.delay. The archive is
 * read with bounds: damaged files give an error and never a crash; a curve holds where its keys
 * run out. Archives with more poses than TAKES_POSES are refused; define it before the header.
 */
#ifndef LIPSYNC_LANG_TAKES_H
#define LIPSYNC_LANG_TAKES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifndef TAKES_POSES
#define TAKES_POSES 128
#endif
#define TAKES_STEPS 1023
#define TAKES_HEADER 64
#define TAKES_SLOT 16
#define TAKES_HEAD 20
#define TAKES_TRACK 16

enum { TAKES_OK, TAKES_NOT_AN_ARCHIVE, TAKES_OTHER_VERSION, TAKES_PATCH, TAKES_TRUNCATED,
       TAKES_DAMAGED, TAKES_TOO_MANY_POSES };
enum { TAKES_MAX, TAKES_ADD, TAKES_REPLACE };

typedef struct {
    const uint8_t *data;
    uint64_t size, index, takes;
    uint32_t count, slots, poses, body_crc;
} takes_archive;

typedef struct {
    const uint8_t *keys, *at; /* first key, next key */
    uint32_t first, last;     /* frames of the span */
    float begin, end, low, scale;
    uint16_t pose, count, left, unused;
} takes_cursor;

typedef struct {
    const takes_archive *archive;
    const uint8_t *stop; /* end of the take */
    double time, start, delay, end, rate, fade, left;
    uint32_t frames;
    int tracks, playing;
    float weights[TAKES_POSES]; /* in the order of takes_pose; 0 at rest */
    float from[TAKES_POSES];
    takes_cursor cursors[TAKES_POSES];
} takes_player;

static inline uint16_t takes_u16(const uint8_t *p) { return (uint16_t)(p[0] | p[1] << 8); }

static inline uint32_t takes_u32(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t takes_u64(const uint8_t *p)
{
    return (uint64_t)takes_u32(p) | (uint64_t)takes_u32(p + 4) << 32;
}

static inline float takes_f32(const uint8_t *p)
{
    uint32_t bits = takes_u32(p);
    float value;
    memcpy(&value, &bits, 4);
    return value;
}

static inline uint32_t takes_crc(uint32_t crc, const uint8_t *p, uint64_t size)
{
    static const uint32_t part[16] = {
        0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158,
        0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4,
        0xa00ae278, 0xbdbdf21c};
    crc = ~crc;
    while (size--) {
        crc ^= *p++;
        crc = part[crc & 15] ^ crc >> 4;
        crc = part[crc & 15] ^ crc >> 4;
    }
    return ~crc;
}

static inline const char *takes_error(int error)
{
    static const char *const told[] = {
        "sound", "is not an archive of takes", "has another version than this player",
        "is a patch: lipsync-lang archive apply", "ends early: copy it again",
        "is damaged: copy it again", "has more poses than TAKES_POSES: define a larger number"};
    return error >= 0 && error <= TAKES_TOO_MANY_POSES ? told[error] : "unknown error";
}

/* Returns the UTF-8 name of a pose, and its length; it has no zero at its end. */
static inline const char *takes_pose(const takes_archive *a, uint32_t number, uint16_t *length)
{
    uint64_t at = TAKES_HEADER;
    if (number >= a->poses) return NULL;
    while (number--) at += 2u + takes_u16(a->data + at);
    *length = takes_u16(a->data + at);
    return (const char *)a->data + at + 2;
}

/* Opens an archive in memory; returns TAKES_OK or an error. The bytes must stay. */
static inline int takes_open(takes_archive *a, const void *bytes, size_t size)
{
    const uint8_t *p = (const uint8_t *)bytes;
    uint64_t at = TAKES_HEADER;
    uint32_t pose;
    memset(a, 0, sizeof *a);
    if (size < 8 || memcmp(p, "LLTAKES", 8)) return TAKES_NOT_AN_ARCHIVE;
    if (size < TAKES_HEADER) return TAKES_TRUNCATED;
    if (takes_u16(p + 8) != 1) return TAKES_OTHER_VERSION;
    if (takes_u16(p + 10)) return TAKES_PATCH;
    a->count = takes_u32(p + 12), a->slots = takes_u32(p + 16), a->poses = takes_u32(p + 20);
    a->index = takes_u64(p + 24), a->takes = takes_u64(p + 32), a->size = takes_u64(p + 40);
    a->body_crc = takes_u32(p + 52);
    if (a->size != size) return a->size > size ? TAKES_TRUNCATED : TAKES_DAMAGED;
    if (a->index < TAKES_HEADER || a->index > a->takes || a->takes > size) return TAKES_DAMAGED;
    if (a->takes - a->index != (uint64_t)a->slots * TAKES_SLOT) return TAKES_DAMAGED;
    if (!a->slots || a->slots & (a->slots - 1)) return TAKES_DAMAGED;
    if (takes_crc(takes_crc(0, p, 48), p + 52, a->takes - 52) != takes_u32(p + 48))
        return TAKES_DAMAGED;
    if (a->poses > TAKES_POSES) return TAKES_TOO_MANY_POSES;
    for (pose = 0; pose < a->poses; pose++) {
        if (at + 2 > a->index) return TAKES_DAMAGED;
        at += 2u + takes_u16(p + at);
        if (at > a->index) return TAKES_DAMAGED;
    }
    a->data = p;
    return TAKES_OK;
}

/* Returns 1 if the checksum of all takes is right; it reads the whole file. */
static inline int takes_is_whole(const takes_archive *a)
{
    return takes_crc(0, a->data + a->takes, a->size - a->takes) == a->body_crc;
}

/* Returns 1 if the head of a take and its tracks are sound. Its keys are checked as they play. */
static inline int takes_is_sound(const takes_archive *a, uint64_t body, uint64_t end)
{
    const uint8_t *p = a->data + body;
    uint64_t size;
    uint32_t frames, number, tracks;
    float rate, start, delay;
    if (body > end || (size = end - body) < TAKES_HEAD) return 0;
    rate = takes_f32(p), start = takes_f32(p + 4), delay = takes_f32(p + 8);
    frames = takes_u32(p + 12), tracks = takes_u16(p + 16);
    if (!(rate > 0 && rate < 1e6f && start > -1e6f && start < 1e6f)) return 0;
    if (!(delay > -1e6f && delay < 1e6f) || !frames || tracks > a->poses) return 0;
    if (size < TAKES_HEAD + (uint64_t)tracks * TAKES_TRACK) return 0;
    for (number = 0; number < tracks; number++) {
        const uint8_t *track = p + TAKES_HEAD + (size_t)number * TAKES_TRACK;
        float low = takes_f32(track + 8), span = takes_f32(track + 12);
        if (takes_u16(track) >= a->poses || !takes_u16(track + 2)) return 0;
        if (takes_u32(track + 4) + 2ull > size) return 0;
        if (!(low > -1e9f && low < 1e9f && span > -1e9f && span < 1e9f)) return 0;
    }
    return 1;
}

/* Returns the position of a take such as "english/intro_001", and its end; 0: no sound one. */
static inline uint64_t takes_find(const takes_archive *a, const char *name, uint64_t *end)
{
    uint32_t hash = 0x811c9dc5u, probe;
    size_t length = strlen(name), n;
    for (n = 0; n < length; n++) hash = (hash ^ (uint8_t)name[n]) * 0x01000193u;
    for (probe = 0; probe < a->slots; probe++) {
        uint32_t slot = (hash + probe) & (a->slots - 1);
        const uint8_t *p = a->data + a->index + (uint64_t)slot * TAKES_SLOT;
        uint64_t at = takes_u64(p), size = takes_u32(p + 12);
        if (!at) return 0;
        if (takes_u32(p + 8) != hash || at >= a->size || size > a->size - at) continue;
        if (size < 4 + length || takes_u16(a->data + at) != length) continue;
        if (memcmp(a->data + at + 4, name, length)) continue;
        n = (size_t)(4 + length + (4 - length % 4) % 4);
        *end = at + size;
        return takes_is_sound(a, at + n, *end) ? at + n : 0;
    }
    return 0;
}

static inline void takes_start(takes_player *w, const takes_archive *archive)
{
    memset(w, 0, sizeof *w);
    w->archive = archive;
}

static inline void takes_rewind(takes_cursor *c)
{
    c->at = c->keys + 2;
    c->left = (uint16_t)(c->count - 1);
    c->first = c->last = 0;
    c->begin = c->end = c->low + (float)(takes_u16(c->keys) & TAKES_STEPS) * c->scale;
}

static inline void takes_next(takes_cursor *c, const uint8_t *stop)
{
    ptrdiff_t size = stop - c->at;
    uint32_t word, step;
    if (size < 2 || (!((word = takes_u16(c->at)) >> 10) && size < 4)) {
        c->left = 0;
        return;
    }
    c->at += 2;
    if (!(step = word >> 10)) step = takes_u16(c->at), c->at += 2;
    c->left--;
    c->first = c->last, c->begin = c->end;
    c->last += step;
    c->end = c->low + (float)(word & TAKES_STEPS) * c->scale;
}

static inline void takes_show(takes_player *w)
{
    double frame = (w->time - w->start) * w->rate, most = w->frames ? w->frames - 1.0 : 0.0;
    uint32_t pose;
    int number;
    memset(w->weights, 0, w->archive->poses * sizeof(float));
    frame = frame > 0 ? (frame < most ? frame : most) : 0;
    for (number = 0; number < w->tracks; number++) {
        takes_cursor *c = &w->cursors[number];
        float share = 1;
        if (frame < c->first) takes_rewind(c);
        while (frame > c->last && c->left) takes_next(c, w->stop);
        if (c->last > c->first) share = (float)((frame - c->first) / (c->last - c->first));
        w->weights[c->pose] = c->begin + (c->end - c->begin) * share;
    }
    if (w->time >= w->end) w->playing = 0;
    if (w->left > 0) {
        float share = (float)(w->left / w->fade);
        for (pose = 0; pose < w->archive->poses; pose++)
            w->weights[pose] += (w->from[pose] - w->weights[pose]) * share;
    }
}

static inline void takes_hold(takes_player *w, double fade)
{
    memcpy(w->from, w->weights, w->archive->poses * sizeof(float));
    w->fade = w->left = fade > 0 ? fade : 0;
}

/* Plays a line from its movement before the sound, and fades from what is shown. Returns 0, and
 * goes on as before, if the archive lacks the line. takes_seek starts elsewhere. */
static inline int takes_play(takes_player *w, const char *name, double fade)
{
    uint64_t end, body = takes_find(w->archive, name, &end);
    const uint8_t *p = w->archive->data + body;
    int number;
    if (!body) return 0;
    takes_hold(w, fade);
    w->stop = w->archive->data + end;
    w->rate = takes_f32(p), w->start = takes_f32(p + 4), w->delay = takes_f32(p + 8);
    w->frames = takes_u32(p + 12), w->tracks = takes_u16(p + 16);
    w->end = w->start + (w->frames - 1.0) / w->rate;
    w->playing = 1;
    for (number = 0; number < w->tracks; number++) {
        const uint8_t *track = p + TAKES_HEAD + number * TAKES_TRACK;
        takes_cursor *c = &w->cursors[number];
        c->pose = takes_u16(track), c->count = takes_u16(track + 2);
        c->keys = p + takes_u32(track + 4);
        c->low = takes_f32(track + 8), c->scale = takes_f32(track + 12) / TAKES_STEPS;
        takes_rewind(c);
    }
    w->time = w->start < 0 ? w->start : 0;
    takes_show(w);
    return 1;
}

/* Plays the same line in another language, from the same share of its length. */
static inline int takes_switch(takes_player *w, const char *name, double fade)
{
    double length = w->end - w->start, share;
    share = (w->time - w->start) / (length > 1e-6 ? length : 1e-6);
    if (!takes_play(w, name, fade)) return 0;
    w->time = w->start + share * (w->end - w->start);
    takes_show(w);
    return 1;
}

static inline void takes_advance(takes_player *w, double seconds)
{
    w->time += seconds;
    w->left = w->left > seconds ? w->left - seconds : 0;
    takes_show(w);
}

/* Goes to a time on the line's timeline; a fade ends. */
static inline void takes_seek(takes_player *w, double time)
{
    w->time = time, w->left = 0;
    takes_show(w);
}

/* Ends the line: fades to rest. */
static inline void takes_skip(takes_player *w, double fade)
{
    takes_hold(w, fade);
    w->playing = w->tracks = 0;
    takes_show(w);
}

/* Seconds of the sound now; it has not started below 0. */
static inline double takes_sound_time(const takes_player *w) { return w->time - w->delay; }

/* Combines speech with the game's own weights; region is used by TAKES_REPLACE: 1 is speech. */
static inline void takes_blend(
    const takes_player *w, const float *own, int mode, const float *region, float *out)
{
    uint32_t pose;
    for (pose = 0; pose < w->archive->poses; pose++) {
        float mine = own[pose], speech = w->weights[pose];
        if (mode == TAKES_MAX) out[pose] = mine > speech ? mine : speech;
        else if (mode == TAKES_ADD) out[pose] = mine + speech < 1 ? mine + speech : 1;
        else out[pose] = mine + (speech - mine) * region[pose];
    }
}

#endif
