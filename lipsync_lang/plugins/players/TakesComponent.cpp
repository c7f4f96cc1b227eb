// See TakesComponent.h.
#include "TakesComponent.h"

#include "Components/AudioComponent.h"
#include "Components/SkeletalMeshComponent.h"
#include "GameFramework/Actor.h"
#include "Misc/FileHelper.h"
#include "Misc/Paths.h"
#include "Sound/SoundBase.h"

UTakesComponent::UTakesComponent()
{
    PrimaryComponentTick.bCanEverTick = true;
}

void UTakesComponent::BeginPlay()
{
    Super::BeginPlay();
    if (!Face) Face = GetOwner()->FindComponentByClass<USkeletalMeshComponent>();
    if (!Voice) Voice = GetOwner()->FindComponentByClass<UAudioComponent>();
    if (!FFileHelper::LoadFileToArray(Bytes, *FPaths::Combine(FPaths::ProjectContentDir(), File)))
    {
        UE_LOG(LogTemp, Error, TEXT("%s is missing in the Content folder"), *File);
        return;
    }
    const int Error = takes_open(&Archive, Bytes.GetData(), Bytes.Num());
    if (Error != TAKES_OK)
    {
        UE_LOG(LogTemp, Error, TEXT("%s %s"), *File, UTF8_TO_TCHAR(takes_error(Error)));
        return;
    }
    takes_start(&Player, &Archive);
    for (uint32 Pose = 0; Pose < Archive.poses; Pose++)
    {
        uint16 Length = 0;
        const char* Name = takes_pose(&Archive, Pose, &Length);
        const FUTF8ToTCHAR Text(Name, Length);
        Poses.Add(FName(Text.Length(), Text.Get()));
    }
    Opened = true;
}

bool UTakesComponent::Play(const FString& Take, USoundBase* Sound, float Fade)
{
    if (!Opened || !takes_play(&Player, TCHAR_TO_UTF8(*Take), Fade)) return false;
    Wait(Sound);
    return true;
}

bool UTakesComponent::Switch(const FString& Take, USoundBase* Sound, float Fade)
{
    if (!Opened || !takes_switch(&Player, TCHAR_TO_UTF8(*Take), Fade)) return false;
    Wait(Sound);
    return true;
}

void UTakesComponent::Skip(float Fade)
{
    if (!Opened) return;
    takes_skip(&Player, Fade);
    Waiting = false;
    if (Voice) Voice->Stop();
}

void UTakesComponent::Wait(USoundBase* Sound)
{
    if (!Voice) return;
    Voice->Stop();
    Voice->SetSound(Sound);
    Waiting = Sound != nullptr;
}

void UTakesComponent::TickComponent(
    float Seconds, ELevelTick Type, FActorComponentTickFunction* Function)
{
    Super::TickComponent(Seconds, Type, Function);
    if (!Opened) return;
    takes_advance(&Player, Seconds);
    const float SoundTime = takes_sound_time(&Player);
    if (Waiting && SoundTime >= 0)
    {
        Waiting = false;
        Voice->Play(SoundTime);
    }
    if (!Face) return;
    for (int32 Pose = 0; Pose < Poses.Num(); Pose++)
        Face->SetMorphTarget(Poses[Pose], Player.weights[Pose]);
}
