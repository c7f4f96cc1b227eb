// Player of archives of takes (.takes) in C#: Unity, Godot with C#, .NET; no dependency.
//
//   var archive = new TakesArchive(File.ReadAllBytes("crab.takes"));
//   var player = new TakesPlayer(archive);      // one for each character
//   player.Play("english/intro_001", 0.1);
//   player.Advance(Time.deltaTime);             // once in each frame; then use player.Weights
//
// Times are seconds on the timeline of a line, whose sound starts at player.Delay. Playing makes no
// objects. A damaged curve holds where its keys run out. An archive serves one thread.
using System;
using System.Text;

namespace LipsyncLang
{
    /// <summary>An archive is damaged, of another version, or not an archive.</summary>
    public sealed class TakesException : Exception
    {
        public TakesException(string message) : base(message) { }
    }

    /// <summary>Ways to combine speech with the game's own expression.</summary>
    public enum TakesBlend { Max, Add, Replace }

    /// <summary>An archive in memory.</summary>
    public sealed class TakesArchive
    {
        internal const int Header = 64, Slot = 16, Head = 20, Track = 16;
        const int Version = 1, CrcAt = 48;
        const string Magic = "LLTAKES\0";

        /// <summary>Names of the poses, in the order of TakesPlayer.Weights.</summary>
        public readonly string[] Poses;

        internal readonly byte[] Data;
        readonly int index, takes;
        readonly uint slots;
        byte[] name = new byte[256];

        /// <summary>Reads the head of an archive; its bytes are not copied.</summary>
        public TakesArchive(byte[] data)
        {
            Data = data;
            for (int at = 0; at < Magic.Length; at++)
                if (at >= data.Length || data[at] != Magic[at])
                    throw new TakesException("is not an archive of takes");
            if (data.Length < Header) throw new TakesException("its header ends early; copy it again");
            if (U16(8) != Version)
                throw new TakesException($"has version {U16(8)}; this player reads {Version}");
            if (U16(10) != 0) throw new TakesException("is a patch, not an archive");
            ulong first = U64(24), body = U64(32), size = U64(40);
            slots = U32(16);
            if (size != (ulong)data.Length)
                throw new TakesException($"has {data.Length} bytes of {size}; copy it again");
            bool ordered = Header <= first && first <= body && body <= size;
            if (!ordered || body - first != (ulong)slots * Slot || !IsPowerOfTwo(slots))
                throw new TakesException("its parts overlap; copy it again");
            index = (int)first;
            takes = (int)body;
            if (Crc(CrcAt + 4, takes, Crc(0, CrcAt)) != U32(CrcAt))
                throw new TakesException("the checksum of its index is wrong; copy it again");
            if (U32(20) > (index - Header) / 2)
                throw new TakesException("its names of poses are damaged; copy it again");
            Poses = new string[U32(20)];
            for (int pose = 0, at = Header; pose < Poses.Length; pose++)
            {
                int length = at + 2 <= index ? U16(at) : data.Length;
                if (length > index - at - 2)
                    throw new TakesException("its names of poses are damaged; copy it again");
                Poses[pose] = Encoding.UTF8.GetString(data, at + 2, length);
                at += 2 + length;
            }
        }

        /// <summary>Returns true if the checksum of all takes is right; it reads all.</summary>
        public bool IsWhole() { return Crc(takes, Data.Length) == U32(CrcAt + 4); }

        /// <summary>Returns true if the archive has a take such as english/intro_001.</summary>
        public bool Has(string take) { return Find(take, out _) != 0; }

        /// <summary>Returns the position of a take and its end; 0 if there is no sound one.</summary>
        internal int Find(string take, out int end)
        {
            int most = Encoding.UTF8.GetMaxByteCount(take.Length);
            if (most > name.Length) name = new byte[most];
            int length = Encoding.UTF8.GetBytes(take, 0, take.Length, name, 0);
            uint hash = 0x811c9dc5;
            for (int at = 0; at < length; at++) hash = unchecked((hash ^ name[at]) * 0x01000193);
            end = 0;
            for (uint probe = 0; probe < slots; probe++)
            {
                int slot = index + (int)(unchecked(hash + probe) & (slots - 1)) * Slot;
                ulong place = U64(slot);
                uint size = U32(slot + 12);
                if (place == 0) return 0;
                if (U32(slot + 8) != hash || place >= (ulong)Data.Length) continue;
                if (size > (ulong)Data.Length - place || size < 4 + length) continue;
                int at = (int)place;
                if (U16(at) != length || !IsName(at + 4, length)) continue;
                int body = at + 4 + (length + 3) / 4 * 4;
                end = at + (int)size;
                return IsSound(body, end) ? body : 0;
            }
            return 0;
        }

        internal ushort U16(int at) { return (ushort)(Data[at] | Data[at + 1] << 8); }

        internal uint U32(int at) { return U16(at) | (uint)U16(at + 2) << 16; }

        internal float F32(int at) { return BitConverter.ToSingle(Data, at); }

        ulong U64(int at) { return U32(at) | (ulong)U32(at + 4) << 32; }

        static bool IsPowerOfTwo(uint number) { return number != 0 && (number & (number - 1)) == 0; }

        bool IsName(int at, int length)
        {
            for (int number = 0; number < length; number++)
                if (Data[at + number] != name[number]) return false;
            return true;
        }

        // The head of a take and its tracks are sound; keys are checked as they play.
        bool IsSound(int body, int end)
        {
            if (body > end - Head) return false;
            float rate = F32(body), start = F32(body + 4), delay = F32(body + 8);
            int tracks = U16(body + 16);
            bool timed = rate > 0 && rate < 1e6f && Math.Abs(start) < 1e6f && Math.Abs(delay) < 1e6f;
            if (!timed || U32(body + 12) == 0 || tracks > Poses.Length) return false;
            if (tracks * Track > end - body - Head) return false;
            for (int track = body + Head; track < body + Head + tracks * Track; track += Track)
            {
                if (U16(track) >= Poses.Length || U16(track + 2) == 0) return false;
                if (U32(track + 4) + 2ul > (ulong)(end - body)) return false;
                float low = F32(track + 8), span = F32(track + 12);
                if (!(Math.Abs(low) < 1e9f && Math.Abs(span) < 1e9f)) return false;
            }
            return true;
        }

        uint Crc(int first, int end, uint crc = 0)
        {
            crc = ~crc;
            for (int at = first; at < end; at++) crc = CrcParts[(crc ^ Data[at]) & 255] ^ crc >> 8;
            return ~crc;
        }

        static readonly uint[] CrcParts = MakeCrcParts();

        static uint[] MakeCrcParts()
        {
            var parts = new uint[256];
            for (uint number = 0; number < 256; number++)
            {
                uint value = number;
                for (int bit = 0; bit < 8; bit++)
                    value = (value & 1) != 0 ? 0xedb88320 ^ value >> 1 : value >> 1;
                parts[number] = value;
            }
            return parts;
        }
    }

    /// <summary>One character that plays lines of an archive.</summary>
    public sealed class TakesPlayer
    {
        const int Steps = 1023;

        /// <summary>Weight of each pose of the archive now; 0 at rest.</summary>
        public readonly float[] Weights;

        public readonly TakesArchive Archive;

        public double Time { get; private set; }

        /// <summary>Time at which the sound starts.</summary>
        public double Delay { get; private set; }

        public double End { get; private set; }

        public bool Playing { get; private set; }

        /// <summary>Seconds of the sound now; it has not started below 0.</summary>
        public double SoundTime { get { return Time - Delay; } }

        // The span between two keys of a track.
        struct Cursor
        {
            public int Pose, Keys, Count, At, Left;
            public uint First, Last;
            public float Begin, Finish, Low, Scale;
        }

        readonly Cursor[] cursors;
        readonly float[] from;
        double start, rate, fade, left;
        uint frames;
        int tracks, stop;

        public TakesPlayer(TakesArchive archive)
        {
            Archive = archive;
            Weights = new float[archive.Poses.Length];
            from = new float[archive.Poses.Length];
            cursors = new Cursor[archive.Poses.Length];
        }

        /// <summary>Plays a line from its movement before the sound, and fades from what is shown.
        /// Returns false, and goes on as before, if the archive lacks the line.</summary>
        public bool Play(string take, double fade = 0)
        {
            int body = Archive.Find(take, out int end);
            if (body == 0) return false;
            Hold(fade);
            stop = end;
            rate = Archive.F32(body);
            start = Archive.F32(body + 4);
            Delay = Archive.F32(body + 8);
            frames = Archive.U32(body + 12);
            tracks = Archive.U16(body + 16);
            End = start + (frames - 1.0) / rate;
            Playing = true;
            for (int number = 0; number < tracks; number++)
            {
                int track = body + TakesArchive.Head + number * TakesArchive.Track;
                ref Cursor one = ref cursors[number];
                one.Pose = Archive.U16(track);
                one.Count = Archive.U16(track + 2);
                one.Keys = body + (int)Archive.U32(track + 4);
                one.Low = Archive.F32(track + 8);
                one.Scale = Archive.F32(track + 12) / Steps;
                Rewind(ref one);
            }
            Time = Math.Min(0, start);
            Show();
            return true;
        }

        /// <summary>Plays the same line in another language, from the same share of it.</summary>
        public bool Switch(string take, double fade = 0)
        {
            double share = (Time - start) / Math.Max(End - start, 1e-6);
            if (!Play(take, fade)) return false;
            Time = start + share * (End - start);
            Show();
            return true;
        }

        /// <summary>Moves on by the time of a frame.</summary>
        public void Advance(double seconds)
        {
            Time += seconds;
            left = Math.Max(0, left - seconds);
            Show();
        }

        /// <summary>Goes to a time on the line's timeline; a fade ends.</summary>
        public void Seek(double time)
        {
            Time = time;
            left = 0;
            Show();
        }

        /// <summary>Ends the line: fades to rest.</summary>
        public void Skip(double fade = 0)
        {
            Hold(fade);
            Playing = false;
            tracks = 0;
            Show();
        }

        /// <summary>Combines speech with the game's own weights into result. Replace takes speech
        /// where region is 1, and the game's own where it is 0.</summary>
        public void Blend(float[] own, TakesBlend mode, float[] region, float[] result)
        {
            for (int pose = 0; pose < Weights.Length; pose++)
            {
                float mine = own[pose], speech = Weights[pose];
                if (mode == TakesBlend.Max) result[pose] = Math.Max(mine, speech);
                else if (mode == TakesBlend.Add) result[pose] = Math.Min(mine + speech, 1);
                else result[pose] = mine + (speech - mine) * region[pose];
            }
        }

        void Hold(double seconds)
        {
            Array.Copy(Weights, from, from.Length);
            fade = left = Math.Max(0, seconds);
        }

        void Rewind(ref Cursor one)
        {
            one.At = one.Keys + 2;
            one.Left = one.Count - 1;
            one.First = one.Last = 0;
            one.Begin = one.Finish = one.Low + (Archive.U16(one.Keys) & Steps) * one.Scale;
        }

        void Next(ref Cursor one)
        {
            int at = one.At, word = at + 2 <= stop ? Archive.U16(at) : 0, step = word >> 10;
            if (step == 0)
            {
                at += 2;
                if (at + 2 > stop)
                {
                    one.Left = 0;
                    return;
                }
                step = Archive.U16(at);
            }
            one.At = at + 2;
            one.Left--;
            one.First = one.Last;
            one.Begin = one.Finish;
            one.Last += (uint)step;
            one.Finish = one.Low + (word & Steps) * one.Scale;
        }

        void Show()
        {
            Array.Clear(Weights, 0, Weights.Length);
            double most = frames > 0 ? frames - 1.0 : 0;
            double frame = Math.Min(Math.Max((Time - start) * rate, 0), most);
            for (int number = 0; number < tracks; number++)
            {
                ref Cursor one = ref cursors[number];
                if (frame < one.First) Rewind(ref one);
                while (frame > one.Last && one.Left > 0) Next(ref one);
                double share = one.Last > one.First ? (frame - one.First) / (one.Last - one.First) : 1;
                Weights[one.Pose] = one.Begin + (one.Finish - one.Begin) * (float)share;
            }
            if (Time >= End) Playing = false;
            if (left <= 0) return;
            float faded = (float)(left / fade);
            for (int pose = 0; pose < Weights.Length; pose++)
                Weights[pose] += (from[pose] - Weights[pose]) * faded;
        }
    }
}
