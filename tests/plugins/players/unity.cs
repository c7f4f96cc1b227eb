// Stand-ins for the types of Unity that TakesFace.cs uses, and a scene of one face that runs it:
// unity ARCHIVE TAKE. Prints, once in each frame, two shapes and
// whether the sound plays.
using System;
using System.Globalization;
using System.IO;
using System.Reflection;
using LipsyncLang;

namespace UnityEngine
{
    public class Object { }

    public class MonoBehaviour : Object { }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class SerializeField : Attribute { }

    public class TextAsset : Object
    {
        public byte[] bytes { get; set; }
    }

    public class Mesh : Object
    {
        // As in Unity: -1 for a shape that the mesh lacks.
        public int GetBlendShapeIndex(string name) { return name == "open" ? 0 : name == "jaw" ? 1 : -1; }
    }

    public class SkinnedMeshRenderer : Object
    {
        public readonly float[] Shown = new float[2];

        public Mesh sharedMesh { get { return new Mesh(); } }

        public void SetBlendShapeWeight(int index, float value) { Shown[index] = value; }
    }

    public class AudioClip : Object
    {
        public float length { get { return 60; } }
    }

    public class AudioSource : Object
    {
        public AudioClip clip { get; set; }
        public float time { get; set; }
        public bool isPlaying { get; private set; }

        public void Play() { isPlaying = true; }

        public void Stop() { isPlaying = false; }
    }

    public static class Input
    {
        public static bool GetMouseButtonDown(int button) { return false; }
    }

    public static class Time
    {
        public static float deltaTime { get { return 1 / 60f; } }
    }
}

static class Scene
{
    static void Send(object to, string message)
    {
        to.GetType().GetMethod(message, BindingFlags.Instance | BindingFlags.NonPublic).Invoke(to, null);
    }

    static void Main(string[] arguments)
    {
        var face = new TakesFace();
        var head = new UnityEngine.SkinnedMeshRenderer();
        var sound = new UnityEngine.AudioSource();
        Action<string, object> inspect = (name, value) => typeof(TakesFace)
            .GetField(name, BindingFlags.Instance | BindingFlags.NonPublic).SetValue(face, value);
        inspect("archive", new UnityEngine.TextAsset { bytes = File.ReadAllBytes(arguments[0]) });
        inspect("renderers", new[] { head });
        inspect("sound", sound);
        Send(face, "Awake");
        if (face.Play("en/none", null) || !face.Play(arguments[1], new UnityEngine.AudioClip(), 0))
            Environment.Exit(3);
        do
        {
            Send(face, "LateUpdate");
            Console.WriteLine(string.Format(
                CultureInfo.InvariantCulture, "{0:F6} {1:F6} {2}", head.Shown[0] / 100,
                head.Shown[1] / 100, sound.isPlaying ? 1 : 0));
        }
        while (face.Player.Playing);
        face.Skip(0);
        if (sound.isPlaying) Environment.Exit(4);
    }
}
