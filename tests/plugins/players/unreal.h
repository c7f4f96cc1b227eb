// Stand-ins for the types of Unreal Engine that TakesComponent uses.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#define UCLASS(...)
#define UPROPERTY(...)
#define UFUNCTION(...)
#define GENERATED_BODY()
#define TEXT(text) text
#define TCHAR_TO_UTF8(text) (text)
#define UTF8_TO_TCHAR(text) (text)
#define UE_LOG(category, verbosity, ...) (std::printf(__VA_ARGS__), std::printf("\n"))

using uint8 = std::uint8_t;
using uint16 = std::uint16_t;
using uint32 = std::uint32_t;
using int32 = std::int32_t;
using TCHAR = char;
template <class T> using TObjectPtr = T*;
enum ELevelTick { LEVELTICK_All };
struct FActorComponentTickFunction { bool bCanEverTick = false; };

struct FString
{
    std::string Text;
    const TCHAR* operator*() const { return Text.c_str(); }
};

struct FName
{
    std::string Text;
    FName(int32 Length, const TCHAR* Name) : Text(Name, Length) {}
    bool operator<(const FName& Other) const { return Text < Other.Text; }
};

struct FUTF8ToTCHAR
{
    std::string Text;
    FUTF8ToTCHAR(const char* Name, int32 Length) : Text(Name, Length) {}
    const TCHAR* Get() const { return Text.c_str(); }
    int32 Length() const { return Text.size(); }
};

template <class T> struct TArray
{
    std::vector<T> Items;
    void Add(const T& One) { Items.push_back(One); }
    T* GetData() { return Items.data(); }
    int32 Num() const { return Items.size(); }
    T& operator[](int32 Number) { return Items[Number]; }
};

struct FPaths
{
    static FString ProjectContentDir() { return {""}; }
    static FString Combine(const FString& Folder, const FString& File) { return {Folder.Text + File.Text}; }
};

struct FFileHelper
{
    static bool LoadFileToArray(TArray<uint8>& Bytes, const TCHAR* Path)
    {
        std::FILE* Stream = std::fopen(Path, "rb");
        if (!Stream) return false;
        for (int Byte = std::fgetc(Stream); Byte != EOF; Byte = std::fgetc(Stream)) Bytes.Add(Byte);
        std::fclose(Stream);
        return true;
    }
};

class USoundBase {};

class USkeletalMeshComponent
{
public:
    std::map<FName, float> Shown;
    void SetMorphTarget(FName Name, float Value) { Shown[Name] = Value; }
};

class UAudioComponent
{
public:
    bool Sounds = false;
    void SetSound(USoundBase*) {}
    void Play(float) { Sounds = true; }
    void Stop() { Sounds = false; }
};

class AActor
{
public:
    USkeletalMeshComponent Mesh;
    UAudioComponent Audio;
    template <class T> T* FindComponentByClass();
};

template <> inline USkeletalMeshComponent* AActor::FindComponentByClass() { return &Mesh; }
template <> inline UAudioComponent* AActor::FindComponentByClass() { return &Audio; }

class UActorComponent
{
public:
    using Super = UActorComponent;
    AActor Actor;
    FActorComponentTickFunction PrimaryComponentTick;
    virtual ~UActorComponent() = default;
    AActor* GetOwner() { return &Actor; }
    virtual void BeginPlay() {}
    virtual void TickComponent(float, ELevelTick, FActorComponentTickFunction*) {}
};
