;; The part of every module that does not depend on the program: the scan loop, forces, traces, strings, faults.
;; Addresses of the system area are those of stcore/program.py.

(memory (export "memory") 1)
(table (export "hooks") 64 funcref)
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

;; eight bytes at a time as long as none of them is the zero
(func $str_copy (param $to i32) (param $from i32) (param $room i32) (local $c i32) (local $eight i64)
  (block $last
    (loop $next
      (br_if $last (i32.lt_u (local.get $room) (i32.const 8)))
      (local.set $eight (i64.load (local.get $from)))
      (br_if $last
        (i64.ne (i64.const 0)
          (i64.and
            (i64.and (i64.sub (local.get $eight) (i64.const 0x0101010101010101)) (i64.const 0x8080808080808080))
            (i64.xor (local.get $eight) (i64.const -1)))))
      (i64.store (local.get $to) (local.get $eight))
      (local.set $to (i32.add (local.get $to) (i32.const 8)))
      (local.set $from (i32.add (local.get $from) (i32.const 8)))
      (local.set $room (i32.sub (local.get $room) (i32.const 8)))
      (br $next)))
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

;; --- traces: every scan copies its row, and 16 rows together are searched for what changed. The control words, whose
;; address is in 80, are those of plcruntime/recorder.py

;; copies a row; 1 when the host has to take out what was found before there is room for 16 more
(func $trace_row (param $c i32) (result i32)
  (local $at i32) (local $end i32) (local $to i32) (local $size i32)
  (local.set $at (i32.load offset=0 (local.get $c)))
  (local.set $end (i32.load offset=4 (local.get $c)))
  (local.set $to (i32.load offset=12 (local.get $c)))
  (loop $range
    (local.set $size (i32.load offset=4 (local.get $at)))
    (memory.copy (local.get $to) (i32.load (local.get $at)) (local.get $size))
    (local.set $to (i32.add (local.get $to) (local.get $size)))
    (local.set $at (i32.add (local.get $at) (i32.const 8)))
    (br_if $range (i32.ne (local.get $at) (local.get $end))))
  (i32.store offset=12 (local.get $c) (local.get $to))
  (if (i32.lt_u (local.get $to) (i32.load offset=16 (local.get $c))) (then (return (i32.const 0))))
  (call $search (local.get $c))
  (i32.or
    (i32.eq (i32.load offset=36 (local.get $c)) (i32.const 0x10000))
    (i32.lt_u
      (i32.sub (i32.load offset=28 (local.get $c)) (i32.load offset=24 (local.get $c)))
      (i32.load offset=32 (local.get $c)))))

;; rows that the host does not want to wait for: the last one stands for those that are missing
(func $search_rows (export "search_rows") (local $c i32) (local $to i32) (local $size i32)
  (local.set $c (i32.load (i32.const 80)))
  (local.set $to (i32.load offset=12 (local.get $c)))
  (local.set $size (i32.load offset=20 (local.get $c)))
  (if (i32.eq (local.get $to) (i32.load offset=8 (local.get $c))) (then (return)))
  (loop $next
    (if (i32.lt_u (local.get $to) (i32.load offset=16 (local.get $c)))
      (then
        (memory.copy (local.get $to) (i32.sub (local.get $to) (local.get $size)) (local.get $size))
        (local.set $to (i32.add (local.get $to) (local.get $size)))
        (br $next))))
  (call $search (local.get $c)))

;; Writes down what changed in 16 rows, two words of 8 bytes at a time: their values where they are not as in the row
;; before, and, downwards from the other end of the buffer, a header: number of the two words, number of the 16 rows,
;; two bits for each row. Of a word that seems to change all the time every value is written: quicker than to compare.
(func $search (param $c i32)
  (local $first i32) (local $end i32) (local $at i32) (local $left i32) (local $changed i32)
  (local $bits i32) (local $bit i32)
  (local $size i32) (local $size2 i32) (local $size3 i32) (local $size4 i32)
  (local $head i32) (local $to i32) (local $key i32) (local $new v128) (local $old v128) (local $seen v128)
  (local.set $first (i32.load offset=8 (local.get $c)))
  (local.set $size (i32.load offset=20 (local.get $c)))
  (local.set $size2 (i32.shl (local.get $size) (i32.const 1)))
  (local.set $size3 (i32.add (local.get $size) (local.get $size2)))
  (local.set $size4 (i32.shl (local.get $size) (i32.const 2)))
  (local.set $end (i32.add (local.get $first) (local.get $size)))
  (local.set $to (i32.load offset=24 (local.get $c)))
  (local.set $head (i32.load offset=28 (local.get $c)))
  (local.set $key (i32.shl (i32.load offset=36 (local.get $c)) (i32.const 16)))
  (loop $pair
    (local.set $old (v128.load (i32.sub (local.get $first) (local.get $size))))
    (local.set $seen (v128.const i64x2 0 0))
    (local.set $at (local.get $first))  ;; no loop: this is most of what recording costs
    (local.set $seen (v128.or (local.get $seen) (v128.or
      (v128.or (v128.xor (local.get $old) (v128.load (local.get $at)))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size)))))
      (v128.or (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size2))))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size3))))))))
    (local.set $at (i32.add (local.get $at) (local.get $size4)))
    (local.set $seen (v128.or (local.get $seen) (v128.or
      (v128.or (v128.xor (local.get $old) (v128.load (local.get $at)))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size)))))
      (v128.or (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size2))))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size3))))))))
    (local.set $at (i32.add (local.get $at) (local.get $size4)))
    (local.set $seen (v128.or (local.get $seen) (v128.or
      (v128.or (v128.xor (local.get $old) (v128.load (local.get $at)))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size)))))
      (v128.or (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size2))))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size3))))))))
    (local.set $at (i32.add (local.get $at) (local.get $size4)))
    (local.set $seen (v128.or (local.get $seen) (v128.or
      (v128.or (v128.xor (local.get $old) (v128.load (local.get $at)))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size)))))
      (v128.or (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size2))))
        (v128.xor (local.get $old) (v128.load (i32.add (local.get $at) (local.get $size3))))))))
    (local.set $at (i32.add (local.get $at) (local.get $size4)))
    (if (v128.any_true (local.get $seen))
      (then
        (local.set $changed (i32.xor (i32.const 3)
          (i64x2.bitmask (i64x2.eq (local.get $seen) (v128.const i64x2 0 0)))))
        (i32.store (local.get $head) (local.get $key))
        (if (i32.and (local.get $changed) (i32.or
              (i64x2.bitmask (i64x2.eq
                (v128.load (local.get $first))
                (v128.load (i32.add (local.get $first) (local.get $size)))))
              (i32.or
                (i64x2.bitmask (i64x2.eq
                  (v128.load (i32.sub (local.get $at) (local.get $size)))
                  (v128.load (i32.sub (local.get $at) (local.get $size2)))))
                (i64x2.bitmask (i64x2.eq
                  (v128.load (i32.add (local.get $first) (i32.shl (local.get $size) (i32.const 3))))
                  (v128.load (i32.add (local.get $first)
                    (i32.sub (i32.shl (local.get $size) (i32.const 3)) (local.get $size)))))))))
          (then  ;; compare, from the last row to the one before the first
            (local.set $at (i32.sub (local.get $at) (local.get $size)))
            (local.set $new (v128.load (local.get $at)))
            (local.set $at (i32.sub (local.get $at) (local.get $size)))
            (local.set $left (i32.const 4))
            (loop $rows
              (local.set $old (v128.load (local.get $at)))
              (local.set $bits (i32.add (i32.shl (local.get $bits) (i32.const 2))
                (i64x2.bitmask (i64x2.eq (local.get $new) (local.get $old)))))
              (local.set $new (v128.load (i32.sub (local.get $at) (local.get $size))))
              (local.set $bits (i32.add (i32.shl (local.get $bits) (i32.const 2))
                (i64x2.bitmask (i64x2.eq (local.get $new) (local.get $old)))))
              (local.set $old (v128.load (i32.sub (local.get $at) (local.get $size2))))
              (local.set $bits (i32.add (i32.shl (local.get $bits) (i32.const 2))
                (i64x2.bitmask (i64x2.eq (local.get $new) (local.get $old)))))
              (local.set $new (v128.load (i32.sub (local.get $at) (local.get $size3))))
              (local.set $bits (i32.add (i32.shl (local.get $bits) (i32.const 2))
                (i64x2.bitmask (i64x2.eq (local.get $new) (local.get $old)))))
              (local.set $at (i32.sub (local.get $at) (local.get $size4)))
              (br_if $rows (local.tee $left (i32.sub (local.get $left) (i32.const 1)))))
            (local.set $bits (i32.xor (local.get $bits) (i32.const -1)))
            (i32.store offset=4 (local.get $head) (local.get $bits))
            (loop $changes
              (local.set $bit (i32.ctz (local.get $bits)))
              (i64.store (local.get $to) (i64.load (i32.add
                (i32.add (local.get $first) (i32.shl (i32.and (local.get $bit) (i32.const 1)) (i32.const 3)))
                (i32.mul (i32.shr_u (local.get $bit) (i32.const 1)) (local.get $size)))))
              (local.set $to (i32.add (local.get $to) (i32.const 8)))
              (br_if $changes (local.tee $bits (i32.and (local.get $bits) (i32.sub (local.get $bits) (i32.const 1)))))))
          (else  ;; every value
            (i32.store offset=4 (local.get $head) (i32.mul (local.get $changed) (i32.const 0x55555555)))
            (local.set $at (i32.add (local.get $first)
              (i32.shl (i32.eq (local.get $changed) (i32.const 2)) (i32.const 3))))
            (local.set $left (i32.const 4))
            (if (i32.eq (local.get $changed) (i32.const 3))
              (then  ;; both words
                (loop $rows
                  (v128.store offset=0 (local.get $to) (v128.load (local.get $at)))
                  (v128.store offset=16 (local.get $to) (v128.load (i32.add (local.get $at) (local.get $size))))
                  (v128.store offset=32 (local.get $to) (v128.load (i32.add (local.get $at) (local.get $size2))))
                  (v128.store offset=48 (local.get $to) (v128.load (i32.add (local.get $at) (local.get $size3))))
                  (local.set $to (i32.add (local.get $to) (i32.const 64)))
                  (local.set $at (i32.add (local.get $at) (local.get $size4)))
                  (br_if $rows (local.tee $left (i32.sub (local.get $left) (i32.const 1))))))
              (else
                (loop $rows
                  (i64.store offset=0 (local.get $to) (i64.load (local.get $at)))
                  (i64.store offset=8 (local.get $to) (i64.load (i32.add (local.get $at) (local.get $size))))
                  (i64.store offset=16 (local.get $to) (i64.load (i32.add (local.get $at) (local.get $size2))))
                  (i64.store offset=24 (local.get $to) (i64.load (i32.add (local.get $at) (local.get $size3))))
                  (local.set $to (i32.add (local.get $to) (i32.const 32)))
                  (local.set $at (i32.add (local.get $at) (local.get $size4)))
                  (br_if $rows (local.tee $left (i32.sub (local.get $left) (i32.const 1)))))))))
        (local.set $head (i32.sub (local.get $head) (i32.const 8)))))
    (local.set $key (i32.add (local.get $key) (i32.const 1)))
    (br_if $pair (i32.ne (local.tee $first (i32.add (local.get $first) (i32.const 16))) (local.get $end))))
  (local.set $first (i32.load offset=8 (local.get $c)))
  (memory.copy
    (i32.sub (local.get $first) (local.get $size))
    (i32.add (local.get $first) (i32.sub (i32.shl (local.get $size4) (i32.const 2)) (local.get $size)))
    (local.get $size))
  (i32.store offset=24 (local.get $c) (local.get $to))
  (i32.store offset=28 (local.get $c) (local.get $head))
  (i32.store offset=36 (local.get $c) (i32.add (i32.load offset=36 (local.get $c)) (i32.const 1)))
  (i32.store offset=12 (local.get $c) (local.get $first)))

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
        (i64.store (i32.const 16) (i64.add (i64.load (i32.const 16)) (i64.load (i32.const 32))))
        (i64.store (i32.const 24) (i64.add (i64.load (i32.const 24)) (i64.const 1)))
        (local.set $done (i64.add (local.get $done) (i64.const 1)))
        (if (i32.load (i32.const 80))
          (then (if (call $trace_row (i32.load (i32.const 80))) (then (return (local.get $done))))))
        (if (i32.load (i32.const 96))
          (then (if (call $condition_holds) (then (return (local.get $done))))))
        (br $next))))
  (local.get $done))
