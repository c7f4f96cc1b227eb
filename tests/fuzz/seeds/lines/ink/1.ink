VAR met = false
=== start ===
Anna: Hello there. #happy
// a comment
* (yes) {met} [Go on.] You go on. -> END
+ Stay -> start
- {met: We met|We did not meet} before. <>
~ met = true
-> END
