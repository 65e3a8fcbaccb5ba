#!/bin/sh
# SPDX-License-Identifier: MPL-2.0
# Input filter of Doxygen: puts the declarations of a header into the group of its folder.
case "$1" in
*/fem/curves/* | */fairing/cor* | */fairing/curv*) group=curves ;;
*/fairing/* | */elements/* | */fem/* | */constraints/* | */skinning/*) group=surfaces ;;
*/sculpting/* | */scenes/session*) group=sculpting ;;
*/mesh/sequence/* | */scenes/sequence*) group=sequences ;;
*/mesh/* | */scenes/mesh*) group=morphing ;;
*/analysis/* | */scenes/stress*) group=shells ;;
*/scenes/* | */io/scene/* | */io/sessions/*) group=scenes ;;
*/io/*) group=files ;;
*) group=core ;;
esac
sed -e "s|^namespace batten {\$|& /** @addtogroup $group */ /**@{*/|" -e 's|^}  // namespace batten$|/**@}*/ &|' "$1"
