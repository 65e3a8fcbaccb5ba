#include "batten/fairing/fair_curve.h"
