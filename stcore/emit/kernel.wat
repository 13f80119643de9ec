;; The part of every module that does not depend on the program: the scan loop, forces, traces, strings, faults.
;; Addresses of the system area are those of stcore/program.py.

(memory (export "memory") 1)
(table (export "hooks") 16 funcref)
(type $condition (func (result i32)))
(global $sp (export "sp") (mut i32) (i32.const 0))

;; --- faults: the values go to the system area, the marker in front of the call tells the place

(func $fault_index (param $i i32) (param $low i32) (param $high i32)
  (i64.store (i32.const 48) (i64.extend_i32_s (local.get $i)))
  (i64.store (i32.const 56) (i64.extend_i32_s (local.get $low)))
  (i64.store (i32.const 64) (i64.extend_i32_s (local.get $high)))
  unreachable)

(func $fault_pointer (param $p i32)
  (i64.store (i32.const 48) (i64.extend_i32_u (local.get $p)))
  unreachable)

(func $fault unreachable)

;; --- integer arithmetic where the instruction would trap on -2147483648 / -1

(func $div_i32 (param $a i32) (param $b i32) (result i32)
  (if (i32.eq (local.get $b) (i32.const -1)) (then (return (i32.sub (i32.const 0) (local.get $a)))))
  (i32.div_s (local.get $a) (local.get $b)))

(func $div_i64 (param $a i64) (param $b i64) (result i64)
  (if (i64.eq (local.get $b) (i64.const -1)) (then (return (i64.sub (i64.const 0) (local.get $a)))))
  (i64.div_s (local.get $a) (local.get $b)))

;; nearest integer, half away from zero: REAL_TO_INT(2.5) = 3, (-2.5) = -3
(func $round (param $x f64) (result f64) (local $whole f64)
  (local.set $whole (f64.trunc (local.get $x)))
  (if (f64.ge (f64.abs (f64.sub (local.get $x) (local.get $whole))) (f64.const 0.5))
    (then (local.set $whole (f64.add (local.get $whole) (f64.copysign (f64.const 1) (local.get $x))))))
  (local.get $whole))

;; --- strings: bytes (STRING) or 16-bit units (WSTRING) up to a zero

(func $str_copy (param $to i32) (param $from i32) (param $room i32) (local $c i32)
  (block $end
    (loop $next
      (br_if $end (i32.eqz (local.get $room)))
      (local.set $c (i32.load8_u (local.get $from)))
      (br_if $end (i32.eqz (local.get $c)))
      (i32.store8 (local.get $to) (local.get $c))
      (local.set $to (i32.add (local.get $to) (i32.const 1)))
      (local.set $from (i32.add (local.get $from) (i32.const 1)))
      (local.set $room (i32.sub (local.get $room) (i32.const 1)))
      (br $next)))
  (i32.store8 (local.get $to) (i32.const 0)))

(func $wstr_copy (param $to i32) (param $from i32) (param $room i32) (local $c i32)
  (block $end
    (loop $next
      (br_if $end (i32.eqz (local.get $room)))
      (local.set $c (i32.load16_u (local.get $from)))
      (br_if $end (i32.eqz (local.get $c)))
      (i32.store16 (local.get $to) (local.get $c))
      (local.set $to (i32.add (local.get $to) (i32.const 2)))
      (local.set $from (i32.add (local.get $from) (i32.const 2)))
      (local.set $room (i32.sub (local.get $room) (i32.const 1)))
      (br $next)))
  (i32.store16 (local.get $to) (i32.const 0)))

;; -1, 0, 1
(func $str_cmp (param $a i32) (param $b i32) (result i32) (local $x i32) (local $y i32)
  (loop $next
    (local.set $x (i32.load8_u (local.get $a)))
    (local.set $y (i32.load8_u (local.get $b)))
    (if (i32.ne (local.get $x) (local.get $y))
      (then (return (select (i32.const -1) (i32.const 1) (i32.lt_u (local.get $x) (local.get $y))))))
    (if (i32.eqz (local.get $x)) (then (return (i32.const 0))))
    (local.set $a (i32.add (local.get $a) (i32.const 1)))
    (local.set $b (i32.add (local.get $b) (i32.const 1)))
    (br $next))
  unreachable)

(func $wstr_cmp (param $a i32) (param $b i32) (result i32) (local $x i32) (local $y i32)
  (loop $next
    (local.set $x (i32.load16_u (local.get $a)))
    (local.set $y (i32.load16_u (local.get $b)))
    (if (i32.ne (local.get $x) (local.get $y))
      (then (return (select (i32.const -1) (i32.const 1) (i32.lt_u (local.get $x) (local.get $y))))))
    (if (i32.eqz (local.get $x)) (then (return (i32.const 0))))
    (local.set $a (i32.add (local.get $a) (i32.const 2)))
    (local.set $b (i32.add (local.get $b) (i32.const 2)))
    (br $next))
  unreachable)

;; --- forced variables: (address, size 1 or 8, 8 bytes value, 8 bytes mask) each; only the bits of the mask change

(func $apply_forces (local $at i32) (local $left i32) (local $to i32)
  (local.set $left (i32.load (i32.const 76)))
  (local.set $at (i32.load (i32.const 72)))
  (loop $next
    (if (local.get $left)
      (then
        (local.set $to (i32.load (local.get $at)))
        (if (i32.eq (i32.load offset=4 (local.get $at)) (i32.const 8))
          (then (i64.store (local.get $to)
            (i64.or (i64.and (i64.load (local.get $to)) (i64.xor (i64.load offset=16 (local.get $at)) (i64.const -1)))
              (i64.and (i64.load offset=8 (local.get $at)) (i64.load offset=16 (local.get $at))))))
          (else (i32.store8 (local.get $to)
            (i32.or (i32.and (i32.load8_u (local.get $to)) (i32.xor (i32.load8_u offset=16 (local.get $at)) (i32.const -1)))
              (i32.and (i32.load8_u offset=8 (local.get $at)) (i32.load8_u offset=16 (local.get $at)))))))
        (local.set $at (i32.add (local.get $at) (i32.const 24)))
        (local.set $left (i32.sub (local.get $left) (i32.const 1)))
        (br $next)))))

;; --- one row of the trace: the words of 8 bytes that are not as they were at the last row, each with row and number;
;; blocks of 4 words are compared at once

(func $trace_row
  (local $at i32) (local $left i32) (local $to i32) (local $from i32) (local $before i32) (local $key i32) (local $end i32)
  (local $low v128) (local $high v128)
  (local.set $to (i32.load (i32.const 88)))
  (if (i32.gt_u (local.get $to) (i32.load (i32.const 92))) (then (return)))
  (local.set $at (i32.load (i32.const 80)))
  (local.set $left (i32.load (i32.const 84)))
  (local.set $before (i32.load (i32.const 116)))
  (local.set $key (i32.load (i32.const 120)))
  (loop $range
    (if (local.get $left)
      (then
        (local.set $from (i32.load (local.get $at)))
        (local.set $end (i32.add (local.get $key) (i32.shl (i32.load offset=4 (local.get $at)) (i32.const 18))))
        (loop $next
          (local.set $low (v128.load (local.get $from)))
          (local.set $high (v128.load offset=16 (local.get $from)))
          (if (v128.any_true (v128.or
                (v128.xor (local.get $low) (v128.load (local.get $before)))
                (v128.xor (local.get $high) (v128.load offset=16 (local.get $before)))))
            (then
              (if (i64.ne (i64.load offset=0 (local.get $from)) (i64.load offset=0 (local.get $before)))
                (then
                  (i32.store (local.get $to) (i32.add (local.get $key) (i32.const 0)))
                  (i64.store offset=4 (local.get $to) (i64.load offset=0 (local.get $from)))
                  (local.set $to (i32.add (local.get $to) (i32.const 12)))))
              (if (i64.ne (i64.load offset=8 (local.get $from)) (i64.load offset=8 (local.get $before)))
                (then
                  (i32.store (local.get $to) (i32.add (local.get $key) (i32.const 65536)))
                  (i64.store offset=4 (local.get $to) (i64.load offset=8 (local.get $from)))
                  (local.set $to (i32.add (local.get $to) (i32.const 12)))))
              (if (i64.ne (i64.load offset=16 (local.get $from)) (i64.load offset=16 (local.get $before)))
                (then
                  (i32.store (local.get $to) (i32.add (local.get $key) (i32.const 131072)))
                  (i64.store offset=4 (local.get $to) (i64.load offset=16 (local.get $from)))
                  (local.set $to (i32.add (local.get $to) (i32.const 12)))))
              (if (i64.ne (i64.load offset=24 (local.get $from)) (i64.load offset=24 (local.get $before)))
                (then
                  (i32.store (local.get $to) (i32.add (local.get $key) (i32.const 196608)))
                  (i64.store offset=4 (local.get $to) (i64.load offset=24 (local.get $from)))
                  (local.set $to (i32.add (local.get $to) (i32.const 12)))))
              (v128.store (local.get $before) (local.get $low))
              (v128.store offset=16 (local.get $before) (local.get $high))))
          (local.set $from (i32.add (local.get $from) (i32.const 32)))
          (local.set $before (i32.add (local.get $before) (i32.const 32)))
          (local.set $key (i32.add (local.get $key) (i32.const 262144)))
          (br_if $next (i32.ne (local.get $key) (local.get $end))))
        (local.set $at (i32.add (local.get $at) (i32.const 8)))
        (local.set $left (i32.sub (local.get $left) (i32.const 1)))
        (br $range))))
  (i32.store (i32.const 88) (local.get $to))
  (i32.store (i32.const 120) (i32.add (i32.load (i32.const 120)) (i32.const 1))))

;; --- whether one of the conditions holds that end a run: those in the first slots of the table

(func $condition_holds (result i32) (local $slot i32)
  (loop $next
    (if (call_indirect (type $condition) (local.get $slot)) (then (return (i32.const 1))))
    (local.set $slot (i32.add (local.get $slot) (i32.const 1)))
    (br_if $next (i32.lt_u (local.get $slot) (i32.load (i32.const 96)))))
  (i32.const 0))

;; --- the scan loop: n scans in one call; fewer when a condition holds or the host interrupts

(func $run (export "run") (param $n i64) (result i64) (local $done i64)
  (loop $next
    (if (i64.lt_s (local.get $done) (local.get $n))
      (then
        (if (i32.atomic.load (i32.const 40)) (then (return (local.get $done))))
        (if (i32.load (i32.const 76)) (then (call $apply_forces)))
        (call $scan)
        (if (i32.load (i32.const 76)) (then (call $apply_forces)))
        (if (i32.load (i32.const 84)) (then (call $trace_row)))
        (i64.store (i32.const 16) (i64.add (i64.load (i32.const 16)) (i64.load (i32.const 32))))
        (i64.store (i32.const 24) (i64.add (i64.load (i32.const 24)) (i64.const 1)))
        (local.set $done (i64.add (local.get $done) (i64.const 1)))
        (if (i32.load (i32.const 96))
          (then (if (call $condition_holds) (then (return (local.get $done))))))
        (br $next))))
  (local.get $done))
