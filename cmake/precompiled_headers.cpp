// Nothing: a target whose headers are precompiled (RigcalTargets.cmake) needs a file to compile.
