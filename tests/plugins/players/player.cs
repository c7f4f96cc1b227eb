// Runs the steps of a file, and prints what each shows: player STEPS.
// With "frames" and an archive, plays a line a million frames, and counts collections of garbage.
using System;
using System.Globalization;
using System.IO;
using System.Linq;
using LipsyncLang;

static class Program
{
    static double Number(string text) { return double.Parse(text, CultureInfo.InvariantCulture); }

    static int Main(string[] arguments)
    {
        if (arguments[0] == "frames") return Frames(arguments[1]);
        TakesPlayer player = null;
        float[] own = null, region = null, result = null;
        foreach (string line in File.ReadLines(arguments[0]))
        {
            string[] parts = line.Split(' ');
            if (parts[0] == "open")
            {
                player = Open(parts[1]);
                Console.WriteLine(player == null ? 0 : 1);
                if (player == null) continue;
                own = player.Weights.Select(_ => 0.3f).ToArray();
                region = player.Weights.Select((_, pose) => (float)(pose % 2)).ToArray();
                result = new float[own.Length];
            }
            if (player == null || parts[0] == "open") continue;
            float[] shown = parts[0] == "blend" ? result : player.Weights;
            switch (parts[0])
            {
                case "play": player.Play(parts[1], Number(parts[2])); break;
                case "switch": player.Switch(parts[1], Number(parts[2])); break;
                case "advance": player.Advance(Number(parts[1])); break;
                case "seek": player.Seek(Number(parts[1])); break;
                case "skip": player.Skip(Number(parts[1])); break;
                default:
                    var mode = (TakesBlend)Enum.Parse(typeof(TakesBlend), parts[1], true);
                    player.Blend(own, mode, region, result);
                    break;
            }
            var told = shown.Select(one => (double)one);
            told = told.Concat(new[] { player.SoundTime, player.Playing ? 1 : 0 });
            Console.WriteLine(string.Join(" ", told.Select(
                one => one.ToString("F6", CultureInfo.InvariantCulture))));
        }
        return 0;
    }

    static TakesPlayer Open(string path)
    {
        try
        {
            return new TakesPlayer(new TakesArchive(File.ReadAllBytes(path)));
        }
        catch (TakesException)
        {
            return null;
        }
    }

    static int Frames(string path)
    {
        var player = new TakesPlayer(new TakesArchive(File.ReadAllBytes(path)));
        float[] own = player.Archive.Poses.Select(_ => 0.3f).ToArray();
        float[] result = own.ToArray();
        for (int frame = 0, before = 0; frame < 1000000; frame++)
        {
            if (frame == 1000) before = GC.CollectionCount(0);
            if (!player.Playing) player.Play("en/line-1", 0.1);
            player.Advance(1.0 / 60);
            player.Blend(own, TakesBlend.Replace, own, result);
            if (frame == 999999) Console.WriteLine(GC.CollectionCount(0) - before);
        }
        return 0;
    }
}
