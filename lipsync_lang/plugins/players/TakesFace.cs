// Component for Unity: plays lines of an archive of takes on a face. It needs takes.cs beside it.
//
// Put it on an object, give it the archive (renamed to end in .bytes, so that Unity imports it as a
// TextAsset), the renderers of the face and an AudioSource, and call Play from your script.
using System.Collections.Generic;
using UnityEngine;

namespace LipsyncLang
{
    public sealed class TakesFace : MonoBehaviour
    {
        [SerializeField] TextAsset archive;
        [SerializeField] SkinnedMeshRenderer[] renderers;
        [SerializeField] AudioSource sound;

        // Most models have shapes from 0 to 100.
        [SerializeField] float fullShape = 100;

        /// <summary>The player; null before Awake.</summary>
        public TakesPlayer Player { get; private set; }

        static readonly Dictionary<TextAsset, TakesArchive> Opened =
            new Dictionary<TextAsset, TakesArchive>();

        int[][] shapes;
        bool waiting;

        void Awake()
        {
            if (!Opened.TryGetValue(archive, out TakesArchive opened))
                Opened[archive] = opened = new TakesArchive(archive.bytes);
            Player = new TakesPlayer(opened);
            shapes = new int[renderers.Length][];
            for (int number = 0; number < renderers.Length; number++)
            {
                shapes[number] = new int[opened.Poses.Length];
                for (int pose = 0; pose < opened.Poses.Length; pose++)
                    shapes[number][pose] =
                        renderers[number].sharedMesh.GetBlendShapeIndex(opened.Poses[pose]);
            }
        }

        /// <summary>Plays a line and its sound, which begins when the movement before it is over.
        /// Returns false if the archive lacks the line.</summary>
        public bool Play(string take, AudioClip clip, double fade = 0.1)
        {
            if (!Player.Play(take, fade)) return false;
            Wait(clip);
            return true;
        }

        /// <summary>Goes on with the same line in another language.</summary>
        public bool Switch(string take, AudioClip clip, double fade = 0.1)
        {
            if (!Player.Switch(take, fade)) return false;
            Wait(clip);
            return true;
        }

        /// <summary>Ends the line and its sound: fades to rest.</summary>
        public void Skip(double fade = 0.1)
        {
            waiting = false;
            if (sound != null) sound.Stop();
            Player.Skip(fade);
        }

        void Wait(AudioClip clip)
        {
            if (sound == null) return;
            sound.Stop();
            sound.clip = clip;
            waiting = clip != null;
        }

        // After Animator: its curves on the same shapes would win otherwise.
        void LateUpdate()
        {
            Player.Advance(Time.deltaTime);
            if (waiting && Player.SoundTime >= 0)
            {
                waiting = false;
                if (Player.SoundTime < sound.clip.length)
                {
                    sound.time = (float)Player.SoundTime;
                    sound.Play();
                }
            }
            for (int number = 0; number < renderers.Length; number++)
                for (int pose = 0; pose < shapes[number].Length; pose++)
                    if (shapes[number][pose] >= 0)
                        renderers[number].SetBlendShapeWeight(
                            shapes[number][pose], Player.Weights[pose] * fullShape);
        }
    }
}
