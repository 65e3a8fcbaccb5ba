#include "batten/apps/commands/sequences/step_result.h"

#include "batten/core/errors.h"

namespace batten {

int SequenceParts::handle(const SequenceScene& scene, const LocatedString& name) const {
  std::vector<std::string> names;
  for (size_t h = 0; h < handles.size(); ++h) {
    if (handles[h].name == name.text) return static_cast<int>(h);
    names.push_back(handles[h].name);
  }
  throw InputError(
      scene.at(name.location) + "found the handle '" + name.text + "', expected " +
      (names.empty() ? "one of [[handle]]: there is none" : expected_one_of(name.text, names)));
}

}  // namespace batten
