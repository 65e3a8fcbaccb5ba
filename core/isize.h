// How many things a container holds, as a number that indices are compared with.
#pragma once

namespace batten {

/// The size of a container as int, as everything in the kernel is numbered: meshes, dofs and lines
/// stay below 2³¹, and what could exceed it is refused where it is made.
template <class Container>
constexpr int isize(const Container& container) {
  return static_cast<int>(container.size());
}

}  // namespace batten
