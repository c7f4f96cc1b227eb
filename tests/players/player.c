/* Runs steps of a file on an archive, and prints the weights after each: player ARCHIVE STEPS. */
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
    bytes = (char *)malloc(*size + 1);
    if (fread(bytes, 1, *size, file) != *size) exit(3);
    bytes[*size] = 0;
    fclose(file);
    return bytes;
}

int main(int count, char **arguments)
{
    static takes_archive archive;
    static takes_player player;
    float own[TAKES_POSES], region[TAKES_POSES], out[TAKES_POSES];
    size_t size;
    char *line, *steps, *bytes = count == 3 ? read_all(arguments[1], &size) : NULL;
    int error = bytes ? takes_open(&archive, bytes, size) : TAKES_NOT_AN_ARCHIVE;
    if (error) return fprintf(stderr, "%s\n", takes_error(error)), 2;
    takes_start(&player, &archive);
    steps = read_all(arguments[2], &size);
    for (line = strtok(steps, "\n"); line; line = strtok(NULL, "\n")) {
        char verb[16], name[64];
        const float *shown = player.weights;
        double value = 0;
        uint32_t pose;
        if (sscanf(line, "%15s %63s %lf", verb, name, &value) < 2) return 3;
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
        printf("%.6f\n", takes_sound_time(&player));
    }
    return 0;
}
