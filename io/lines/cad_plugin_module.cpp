// Entry point of the plug-in module for everything that needs OpenCASCADE. Variables that the
// program has too, such as the list of temporary files, are those of the program, because its
// symbols take precedence.
#include "batten/io/lines/cad_plugin.h"

extern "C" const batten::CadPlugin* batten_cad() { return &batten::linked_cad_plugin(); }
