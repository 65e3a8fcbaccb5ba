#include "batten/fairing/curve_fit.h"
