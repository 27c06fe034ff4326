// Nothing: a target with precompiled headers needs a file to compile.
