/* Damages an archive many times and plays what opens: fuzz ARCHIVE ROUNDS NAME... */
#include <stdio.h>
#include <stdlib.h>

#include "takes.h"

static uint32_t state = 1;

static uint32_t chance(uint32_t below)
{
    state ^= state << 13, state ^= state >> 17, state ^= state << 5;
    return state % below;
}

/* Damages some bytes, and lets the checksums fit half of the time, so that deeper code is met. */
static size_t damage(uint8_t *bytes, size_t size)
{
    uint32_t number, edits = 1 + chance(6);
    for (number = 0; number < edits; number++) {
        uint64_t takes = takes_u64(bytes + 32);
        size_t from = chance(3) && takes < size ? (size_t)takes : chance(2) ? 8 : 64;
        size_t at = from + chance((uint32_t)(size - from));
        bytes[at] = (uint8_t)(chance(3) ? chance(256) : chance(2) ? 255 : 0);
    }
    if (!chance(8)) size = 1 + chance((uint32_t)size);
    if (size >= 64 && chance(4)) {
        uint64_t takes = takes_u64(bytes + 32);
        uint32_t crc, byte;
        if (chance(2))
            for (byte = 0; byte < 8; byte++) bytes[40 + byte] = (uint8_t)((uint64_t)size >> 8 * byte);
        if (takes >= 64 && takes <= size) {
            crc = takes_crc(takes_crc(0, bytes, 48), bytes + 52, takes - 52);
            for (byte = 0; byte < 4; byte++) bytes[48 + byte] = (uint8_t)(crc >> 8 * byte);
        }
    }
    return size;
}

int main(int count, char **arguments)
{
    FILE *file = fopen(arguments[1], "rb");
    uint8_t whole[1 << 16], *bytes;
    static takes_archive archive;
    static takes_player player;
    size_t size = fread(whole, 1, sizeof whole, file), now;
    int round, number, step, rounds = atoi(arguments[2]), opened = 0, played = 0;
    fclose(file);
    for (round = 0; round < rounds; round++) {
        uint8_t *trial = (uint8_t *)malloc(size);
        memcpy(trial, whole, size);
        now = damage(trial, size);
        bytes = (uint8_t *)malloc(now); /* of its own size: the sanitizer sees every step over it */
        memcpy(bytes, trial, now);
        free(trial);
        if (takes_open(&archive, bytes, now) == TAKES_OK) {
            uint32_t pose;
            uint16_t length;
            opened++;
            takes_is_whole(&archive);
            for (pose = 0; pose <= archive.poses; pose++) takes_pose(&archive, pose, &length);
            takes_start(&player, &archive);
            for (number = 3; number < count; number++) {
                played += takes_play(&player, arguments[number], 0.1);
                for (step = 0; step < 20; step++) takes_advance(&player, 0.1);
                takes_seek(&player, chance(200) / 100.0);
                takes_switch(&player, arguments[number], 0.1);
                takes_skip(&player, 0.1);
            }
        }
        free(bytes);
    }
    return printf("%d %d\n", opened, played), 0;
}
