// Component for Unreal Engine 5: plays lines of an archive of takes on a face. It needs takes.h.
//
// Add it to an actor with a skeletal mesh, name the archive in File (below the Content folder, and
// staged as a file: "Additional Non-Asset Directories to Copy"), and call Play.
#pragma once

#include "CoreMinimal.h"
#include "Components/ActorComponent.h"
#include "takes.h"
#include "TakesComponent.generated.h"

class USkeletalMeshComponent;
class UAudioComponent;
class USoundBase;

UCLASS(ClassGroup = (Animation), meta = (BlueprintSpawnableComponent))
class UTakesComponent : public UActorComponent
{
    GENERATED_BODY()

public:
    UTakesComponent();

    /** The archive, such as "Voice/crab.takes" in the Content folder. */
    UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Takes")
    FString File;

    /** The face; empty: the first skeletal mesh of the actor. */
    UPROPERTY(BlueprintReadWrite, Category = "Takes")
    TObjectPtr<USkeletalMeshComponent> Face;

    /** What sounds; empty: the first audio component of the actor. */
    UPROPERTY(BlueprintReadWrite, Category = "Takes")
    TObjectPtr<UAudioComponent> Voice;

    /** Plays a line such as "english/intro_001"; false if the archive lacks it. */
    UFUNCTION(BlueprintCallable, Category = "Takes")
    bool Play(const FString& Take, USoundBase* Sound, float Fade = 0.1f);

    /** Goes on with the same line in another language. */
    UFUNCTION(BlueprintCallable, Category = "Takes")
    bool Switch(const FString& Take, USoundBase* Sound, float Fade = 0.1f);

    /** Ends the line and its sound: fades to rest. */
    UFUNCTION(BlueprintCallable, Category = "Takes")
    void Skip(float Fade = 0.1f);

    UFUNCTION(BlueprintPure, Category = "Takes")
    bool IsPlaying() const { return Opened && Player.playing; }

    virtual void BeginPlay() override;
    virtual void TickComponent(
        float Seconds, ELevelTick Type, FActorComponentTickFunction* Function) override;

private:
    void Wait(USoundBase* Sound);

    TArray<uint8> Bytes;
    TArray<FName> Poses;
    takes_archive Archive;
    takes_player Player;
    bool Opened = false;
    bool Waiting = false;
};
