// Runs steps of a file on an archive, and prints the weights after each: player ARCHIVE STEPS.
// With "damaged" and a folder, plays every file in it, and counts those refused and those played.
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
        if (arguments[0] == "damaged") return Damaged(arguments[1]);
        if (arguments[0] == "frames") return Frames(arguments[1]);
        TakesArchive archive;
        try
        {
            archive = new TakesArchive(File.ReadAllBytes(arguments[0]));
        }
        catch (TakesException error)
        {
            Console.Error.WriteLine(error.Message);
            return 2;
        }
        if (!archive.IsWhole()) throw new Exception("the archive is damaged");
        var player = new TakesPlayer(archive);
        float[] own = archive.Poses.Select(_ => 0.3f).ToArray();
        float[] region = archive.Poses.Select((_, pose) => (float)(pose % 2)).ToArray();
        var result = new float[own.Length];
        foreach (string line in File.ReadLines(arguments[1]))
        {
            string[] parts = line.Split(' ');
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
            var told = shown.Select(one => (double)one).Concat(new[] { player.SoundTime });
            Console.WriteLine(string.Join(" ", told.Select(
                one => one.ToString("F6", CultureInfo.InvariantCulture))));
        }
        return 0;
    }

    static int Damaged(string folder)
    {
        int refused = 0, played = 0;
        foreach (string path in Directory.GetFiles(folder))
        {
            TakesPlayer player;
            try
            {
                player = new TakesPlayer(new TakesArchive(File.ReadAllBytes(path)));
            }
            catch (TakesException)
            {
                refused++;
                continue;
            }
            for (int line = 0; line < 6; line++)
            {
                if (player.Play("en/" + line, 0.1)) played++;
                for (int step = 0; step < 20; step++) player.Advance(0.1);
                player.Seek(0.3);
                player.Switch("en/" + line, 0.1);
                player.Skip(0.1);
            }
        }
        Console.WriteLine($"{refused} {played}");
        return 0;
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
