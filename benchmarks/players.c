/* Time of a frame for characters that speak at once: players ARCHIVE CHARACTERS NAME...
 * Prints ms: the frame in which all begin, and the mean of the others. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "takes.h"

static double now(void)
{
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int count, char **arguments)
{
    FILE *file = fopen(arguments[1], "rb");
    int characters = atoi(arguments[2]), number, frame, frames = 601, lines = count - 3, next = 0;
    takes_player *players = (takes_player *)calloc((size_t)characters, sizeof *players);
    takes_archive archive;
    uint8_t *bytes;
    double begin, first = 0, total = 0;
    size_t size;
    fseek(file, 0, SEEK_END);
    size = (size_t)ftell(file);
    rewind(file);
    bytes = (uint8_t *)malloc(size);
    if (fread(bytes, 1, size, file) != size || takes_open(&archive, bytes, size)) return 2;
    for (number = 0; number < characters; number++) takes_start(&players[number], &archive);
    for (frame = 0; frame < frames; frame++) {
        begin = now();
        for (number = 0; number < characters; number++) {
            if (!players[number].playing)
                takes_play(&players[number], arguments[3 + next++ % lines], 0.1);
            takes_advance(&players[number], 1.0 / 60 * (1 + number % 3 * 0.01));
        }
        begin = now() - begin;
        if (!frame) first = begin;
        else total += begin;
    }
    return printf("%.4f %.4f\n", 1e3 * first, 1e3 * total / (frames - 1)), 0;
}
