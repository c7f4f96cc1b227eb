/* Runs the steps of a file, and prints what each shows: player STEPS. */
#include <stdio.h>
#include <stdlib.h>

#include "takes.h"

static char *read_all(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    char *bytes;
    if (!file) exit(3);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    bytes = (char *)malloc(*size); /* of its own size: the sanitizer sees every step over it */
    if (fread(bytes, 1, *size, file) != *size) exit(3);
    fclose(file);
    return bytes;
}

int main(int count, char **arguments)
{
    static takes_archive archive;
    static takes_player player;
    static char line[4096], name[4096];
    float own[TAKES_POSES], region[TAKES_POSES], out[TAKES_POSES];
    FILE *steps = count == 2 ? fopen(arguments[1], "r") : NULL;
    char *bytes = NULL;
    int error = TAKES_NOT_AN_ARCHIVE;
    if (!steps) return 3;
    while (fgets(line, sizeof line, steps)) {
        char verb[16];
        const float *shown = player.weights;
        double value = 0;
        uint32_t pose;
        if (sscanf(line, "%15s %4095s %lf", verb, name, &value) < 2) return 3;
        if (!strcmp(verb, "open")) {
            size_t size;
            free(bytes);
            bytes = read_all(name, &size);
            error = takes_open(&archive, bytes, size);
            takes_start(&player, &archive);
            printf("%d\n", error == TAKES_OK);
        }
        if (error || !strcmp(verb, "open")) continue;
        if (!strcmp(verb, "play")) takes_play(&player, name, value);
        else if (!strcmp(verb, "switch")) takes_switch(&player, name, value);
        else if (!strcmp(verb, "advance")) takes_advance(&player, atof(name));
        else if (!strcmp(verb, "seek")) takes_seek(&player, atof(name));
        else if (!strcmp(verb, "skip")) takes_skip(&player, atof(name));
        else {
            int mode = !strcmp(name, "max") ? TAKES_MAX : TAKES_ADD;
            for (pose = 0; pose < archive.poses; pose++) own[pose] = 0.3f, region[pose] = pose % 2;
            takes_blend(&player, own, strcmp(name, "replace") ? mode : TAKES_REPLACE, region, out);
            shown = out;
        }
        for (pose = 0; pose < archive.poses; pose++) printf("%.6f ", shown[pose]);
        printf("%.6f %d\n", takes_sound_time(&player), player.playing);
    }
    free(bytes);
    return fclose(steps);
}
