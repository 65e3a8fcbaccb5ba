#include "batten/fairing/fairness.h"
