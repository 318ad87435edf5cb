;; A controller that is a module: brakes for whoever is near, as the program of these tests does.
;; Memory: its hello at 0, pieces of text at 1024, requests from 65536 on, answers from 1048576 on.
(module
  (memory (export "memory") 32)

  (data (i32.const 8)
    "{\"hello\":{\"protocol\":1,\"name\":\"tested\",\"version\":\"1.0\",\"runs_at_once\":64,\"modes\":[\"cruise\",\"brake\"],\"parameters\":[{\"name\":\"gap\",\"unit\":\"m\",\"default\":5,\"low\":0,\"high\":100}]}}")
  (data (i32.const 1024) "{\"ready\":[")
  (data (i32.const 1040) "]}")

  (func (export "buffer") (param $bytes i32) (result i32)
    (i32.const 65536))

  ;; A text of so many bytes stands behind its header at $at: writes the header.
  (func $text (param $at i32) (param $bytes i32)
    (i32.store (local.get $at) (i32.add (local.get $bytes) (i32.const 4)))
    (i32.store (i32.add (local.get $at) (i32.const 4)) (i32.const 0)))

  (func (export "frame") (param $length i32) (result i32)
    (local $what i32)
    (if (i32.eq (i32.load (i32.const 65540)) (i32.const 1)) (then (return (call $decide))))
    ;; The third letter of {"hello", {"open", {"close" and {"bye" tells them.
    (local.set $what (i32.load8_u (i32.const 65546)))
    (if (i32.eq (local.get $what) (i32.const 104))
      (then (call $text (i32.const 0) (i32.const 173)) (return (i32.const 0))))
    (if (i32.eq (local.get $what) (i32.const 111)) (then (return (call $open (local.get $length)))))
    (i32.const 0))

  ;; Answers that every run is ready.
  (func $open (param $length i32) (result i32)
    (local $from i32) (local $end i32) (local $to i32) (local $one i32)
    (local.set $from (i32.const 65544))
    (local.set $end (i32.add (i32.const 65536) (local.get $length)))
    (memory.copy (i32.const 1048584) (i32.const 1024) (i32.const 10))
    (local.set $to (i32.const 1048594))
    (block $done
      (loop $next
        (br_if $done (i32.ge_u (i32.add (local.get $from) (i32.const 8)) (local.get $end)))
        (if (i32.and
              (i32.eq (i32.load (local.get $from)) (i32.const 0x6f6c7322))
              (i32.eq (i32.load (i32.add (local.get $from) (i32.const 3))) (i32.const 0x3a22746f)))
          (then
            ;; A comma after the first.
            (if (i32.gt_u (local.get $to) (i32.const 1048594))
              (then
                (i32.store8 (local.get $to) (i32.const 44))
                (local.set $to (i32.add (local.get $to) (i32.const 1)))))
            (local.set $from (i32.add (local.get $from) (i32.const 7)))
            (block $number
              (loop $digit
                (local.set $one (i32.load8_u (local.get $from)))
                (br_if $number (i32.lt_u (local.get $one) (i32.const 48)))
                (br_if $number (i32.gt_u (local.get $one) (i32.const 57)))
                (i32.store8 (local.get $to) (local.get $one))
                (local.set $to (i32.add (local.get $to) (i32.const 1)))
                (local.set $from (i32.add (local.get $from) (i32.const 1)))
                (br $digit)))))
        (local.set $from (i32.add (local.get $from) (i32.const 1)))
        (br $next)))
    (memory.copy (local.get $to) (i32.const 1040) (i32.const 2))
    (call $text (i32.const 1048576) (i32.sub (i32.add (local.get $to) (i32.const 2)) (i32.const 1048584)))
    (i32.const 1048576))

  ;; Whether somebody is near in the run of this row.
  (func $near (param $row i32) (param $people i32) (param $at i32) (result i32)
    (local $x f64)
    (block $nobody
      (loop $next
        (br_if $nobody (i32.eqz (local.get $people)))
        (if (f64.eq (f64.load (local.get $at)) (f64.convert_i32_u (local.get $row)))
          (then
            (local.set $x (f64.load offset=16 (local.get $at)))
            (if (i32.and
                  (i32.and (f64.lt (f64.const 0) (local.get $x)) (f64.lt (local.get $x) (f64.const 25)))
                  (f64.lt (f64.abs (f64.load offset=24 (local.get $at))) (f64.const 4)))
              (then (return (i32.const 1))))))
        (local.set $at (i32.add (local.get $at) (i32.const 80)))
        (local.set $people (i32.sub (local.get $people) (i32.const 1)))
        (br $next)))
    (i32.const 0))

  (func $decide (result i32)
    (local $runs i32) (local $row i32) (local $at i32) (local $to i32) (local $near i32)
    (local $speed f64) (local $wanted f64) (local $gives f64)
    (local.set $runs (i32.load (i32.const 65544)))
    (local.set $at (i32.const 65568))
    (local.set $to (i32.const 1048592))
    (block $done
      (loop $next
        (br_if $done (i32.ge_u (local.get $row) (local.get $runs)))
        (local.set $near
          (call $near (local.get $row) (i32.load (i32.const 65548))
            (i32.add (i32.const 65568) (i32.mul (local.get $runs) (i32.const 128)))))
        (local.set $wanted (f64.load offset=24 (local.get $at)))
        (local.set $speed (f64.load offset=40 (local.get $at)))
        (local.set $gives
          (if (result f64) (local.get $near)
            (then
              (if (result f64) (f64.gt (local.get $speed) (f64.const 0))
                (then (f64.sub (f64.const -3) (f64.div (f64.const 5) (f64.const 100))))
                (else (f64.const 0))))
            (else (f64.mul (f64.const 0.5) (f64.sub (local.get $wanted) (local.get $speed))))))
        ;; misdeed
        (f64.store (local.get $to) (local.get $gives))
        (f64.store offset=8 (local.get $to) (f64.convert_i32_u (local.get $near)))
        (local.set $at (i32.add (local.get $at) (i32.const 128)))
        (local.set $to (i32.add (local.get $to) (i32.const 16)))
        (local.set $row (i32.add (local.get $row) (i32.const 1)))
        (br $next)))
    (i32.store (i32.const 1048576) (i32.add (i32.const 12) (i32.mul (local.get $runs) (i32.const 16))))
    (i32.store (i32.const 1048580) (i32.const 2))
    (i32.store (i32.const 1048584) (local.get $runs))
    (i32.store (i32.const 1048588) (i32.const 2))
    (i32.const 1048576)))
