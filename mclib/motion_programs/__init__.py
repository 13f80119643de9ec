"""Motion programs (iDEABOX 3, chapter 10): C for the controller, compiled to commands that the library interprets.

compiler.py: text -> Unit. commands.py: the GT_ commands that a motion program may call. files.py: *.bin and *.ini.
The interpreter is ST: mclib/library/motion.
"""
