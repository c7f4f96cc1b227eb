# Speaker: Anna
hello = Hello, { $name }!
    Nice day at { -brand }.
-brand = Mapland
maps =
    { $count ->
        [one] One map.
       *[other] { $count } maps.
    }
button = Go
    .label = Press "me"
