// SPDX-License-Identifier: MPL-2.0
// The message of a rejected input.
#pragma once

#include <string>

#include "batten/core/errors.h"

namespace batten_test {

/// The message of the InputError that `action` throws, or "".
template <class Action>
std::string error_message(const Action& action) {
  try {
    action();
  } catch (const batten::InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace batten_test
