#include "batten/tests/catch.h"
