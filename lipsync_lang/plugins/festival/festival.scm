; What Festival runs for one text. `stretch` is set before; the text and the voice's name are read
; from files and stay strings: nothing of them is ever read as Scheme.

(define (whole name)
  (let ((file (fopen name "rb")) (text ""))
    (set! text (fread 1000000 file))
    (fclose file)
    text))

(define (known name voices)
  (cond
    ((null? voices) nil)
    ((string-equal name (car voices)) (car voices))
    (t (known name (cdr voices)))))

(define (speak voice)
  (eval (list (intern (string-append "voice_" voice))))
  (Param.set 'Duration_Stretch (* stretch (Param.get 'Duration_Stretch)))
  (set! utterance (utt.synth (eval (list 'Utterance 'Text (whole "text")))))
  (format t "phones %s\n" (Param.get 'PhoneSet))
  (set! number 0)
  (mapcar
    (lambda (token)
      (if (not (item.parent token)) ; its words are below it
        (begin
          (set! number (+ 1 number))
          (item.set_feat token "number" number)
          (format t "token %s\n" (item.name token)))))
    (utt.relation.items utterance 'Token))
  (mapcar
    (lambda (segment)
      (format t "sound %s %f %s %s\n" (item.name segment) (item.feat segment "end")
        (item.feat segment "R:SylStructure.parent.parent.R:Token.parent.number")
        (if (string-equal (item.feat segment "ph_vc") "+")
          (item.feat segment "R:SylStructure.parent.stress")
          "-")))
    (utt.relation.items utterance 'Segment))
  (utt.save.wave utterance "sound.wav" 'riff))

(let ((voice (known (whole "voice") (voice.list))))
  (if voice
    (speak voice)
    (mapcar (lambda (name) (format t "voice %s\n" name)) (voice.list))))
