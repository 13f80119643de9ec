;; Only in a probed build: what stands in front of every statement. Addresses as in stcore/program.py. The flag of a site
;; is 0, 1 for a breakpoint, or the slot in the table of hooks of a breakpoint's condition.

(type $at_stop (func (param i32 i32) (result i32)))

(func $stop (param $site i32) (param $body i32) (param $this i32) (param $frame i32) (local $count i32) (local $flag i32)
  (local $mode i32)
  (local.set $count (i32.add (global.get $counts) (i32.shl (local.get $site) (i32.const 2))))
  (i32.store (local.get $count) (i32.add (i32.load (local.get $count)) (i32.const 1)))
  (if (i32.load (i32.const 100))
    (then
      (local.set $flag (i32.load8_u (i32.add (global.get $flags) (local.get $site))))
      (if (i32.gt_u (local.get $flag) (i32.const 1))
        (then
          ;; what it calls shall not stop
          (local.set $mode (i32.load (i32.const 100)))
          (i32.store (i32.const 100) (i32.const 0))
          (i32.store (i32.const 116) (i32.const 1))
          (local.set $flag
            (call_indirect (type $at_stop) (local.get $this) (local.get $frame) (local.get $flag)))
          (i32.store (i32.const 116) (i32.const 0))
          (if (i32.eqz (i32.load (i32.const 100))) (then (i32.store (i32.const 100) (local.get $mode))))))
      (if (i32.or
            (local.get $flag)
            (i32.and
              (i32.eq (i32.load (i32.const 100)) (i32.const 2))
              (i32.le_s (i32.load (i32.const 104)) (i32.load (i32.const 108)))))
        (then (call $probe (local.get $site) (local.get $body) (local.get $this) (local.get $frame)))))))

(func $enter (i32.store (i32.const 104) (i32.add (i32.load (i32.const 104)) (i32.const 1))))
(func $leave (i32.store (i32.const 104) (i32.sub (i32.load (i32.const 104)) (i32.const 1))))

(func $taken (param $branch i32) (local $count i32)
  (local.set $count (i32.add (global.get $branches) (i32.shl (local.get $branch) (i32.const 2))))
  (i32.store (local.get $count) (i32.add (i32.load (local.get $count)) (i32.const 1))))
