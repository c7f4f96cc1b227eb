// A scene of one face with the component: unreal ARCHIVE TAKE. Prints, once in each frame, two
// morph targets and whether the sound plays.
#include "TakesComponent.h"

int main(int, char** Arguments)
{
    USoundBase Sound;
    UTakesComponent Speaking;
    Speaking.File = {Arguments[1]};
    Speaking.BeginPlay();
    if (Speaking.Play({"en/none"}, nullptr) || !Speaking.Play({Arguments[2]}, &Sound, 0)) return 3;
    AActor& Actor = *Speaking.GetOwner();
    do
    {
        Speaking.TickComponent(1 / 60.0f, LEVELTICK_All, nullptr);
        std::printf("%f %f %d\n", Actor.Mesh.Shown.at(FName(4, "open")),
                    Actor.Mesh.Shown.at(FName(3, "jaw")), Actor.Audio.Sounds);
    } while (Speaking.IsPlaying());
    Speaking.Skip(0);
    return Actor.Audio.Sounds ? 4 : 0;
}
