// SPDX-License-Identifier: MPL-2.0
// All texts of the window, ready for translation.
#pragma once

#include <QCoreApplication>
#include <QString>

#include <string>
#include <utility>

namespace batten::studio {

/// Translates a text into the user's language.
inline QString text(const char* english) { return QCoreApplication::translate("studio", english); }

/// Converts a name or a message of the kernel for display; not translated.
inline QString shown(const std::string& words) { return QString::fromStdString(words); }

inline constexpr const char* kProgram = QT_TRANSLATE_NOOP("studio", "batten-studio");
inline constexpr const char* kHintSelect =
    QT_TRANSLATE_NOOP("studio",
                      "Click a curve or a face to select it. Drag points of the selected curve; "
                      "double-click it to add one. Drag the background to orbit, wheel to zoom.");
inline constexpr const char* kHintPush =
    QT_TRANSLATE_NOOP("studio",
                      "Press on the surface and drag: the surface follows the pointer. Drag the "
                      "background to orbit.");
inline constexpr const char* kHintDraw = QT_TRANSLATE_NOOP(
    "studio",
    "Click the points of a curve. Near the end of another curve, a point snaps to that end.");
inline constexpr const char* kHintDrawing = QT_TRANSLATE_NOOP(
    "studio",
    "Enter or a double click ends the curve, Backspace removes the last point, Esc cancels.");

inline constexpr const char* kHintSelectMesh =
    QT_TRANSLATE_NOOP("studio",
                      "Click a hole or a painted part, then choose its role on the left. Arrows "
                      "and rings move the handle.");
inline constexpr const char* kHintPaint = QT_TRANSLATE_NOOP(
    "studio", "Paint nodes; with Shift, the brush erases. Drag the background to orbit.");
inline constexpr const char* kHintPath =
    QT_TRANSLATE_NOOP("studio",
                      "Draw a path on the ground for all frames to follow; Enter ends it. A new "
                      "path replaces the old one.");
inline constexpr const char* kHintPaintArea =
    QT_TRANSLATE_NOOP("studio",
                      "Paint the area of the selected load or stiffness field, or of a new one; "
                      "with Shift, the brush erases. Its slider is on the right.");
inline constexpr const char* kHintLasso =
    QT_TRANSLATE_NOOP("studio",
                      "Draw a closed curve around nodes, with Shift to deselect them. Hidden nodes "
                      "at the back are included.");

inline constexpr const char* kFile = QT_TRANSLATE_NOOP("studio", "&File");
inline constexpr const char* kEdit = QT_TRANSLATE_NOOP("studio", "&Edit");
inline constexpr const char* kViewMenu = QT_TRANSLATE_NOOP("studio", "&View");
inline constexpr const char* kTools = QT_TRANSLATE_NOOP("studio", "&Tools");
inline constexpr const char* kHelp = QT_TRANSLATE_NOOP("studio", "&Help");
inline constexpr const char* kNew = QT_TRANSLATE_NOOP("studio", "&New");
inline constexpr const char* kOpen = QT_TRANSLATE_NOOP("studio", "&Open…");
inline constexpr const char* kRecent = QT_TRANSLATE_NOOP("studio", "Open &recent");
inline constexpr const char* kSave = QT_TRANSLATE_NOOP("studio", "&Save");
inline constexpr const char* kSaveAs = QT_TRANSLATE_NOOP("studio", "Save &as…");
inline constexpr const char* kExport = QT_TRANSLATE_NOOP("studio", "&Export…");
inline constexpr const char* kRun = QT_TRANSLATE_NOOP("studio", "Run scene (&write all outputs)…");
inline constexpr const char* kSaveScript = QT_TRANSLATE_NOOP("studio", "Save session as s&cript…");
inline constexpr const char* kQuit = QT_TRANSLATE_NOOP("studio", "&Quit");
inline constexpr const char* kUndo = QT_TRANSLATE_NOOP("studio", "&Undo");
inline constexpr const char* kRedo = QT_TRANSLATE_NOOP("studio", "&Redo");
inline constexpr const char* kRemove = QT_TRANSLATE_NOOP("studio", "&Delete");
inline constexpr const char* kSelect = QT_TRANSLATE_NOOP("studio", "Select");
inline constexpr const char* kPush = QT_TRANSLATE_NOOP("studio", "Push");
inline constexpr const char* kDraw = QT_TRANSLATE_NOOP("studio", "Draw curve");
inline constexpr const char* kPaint = QT_TRANSLATE_NOOP("studio", "Paint");
inline constexpr const char* kLasso = QT_TRANSLATE_NOOP("studio", "Lasso");
inline constexpr const char* kFixPoint = QT_TRANSLATE_NOOP("studio", "Fix point");
inline constexpr const char* kHintFixPoint =
    QT_TRANSLATE_NOOP("studio",
                      "Click the surface to fix that point, with Shift its normal. Drag the arrows "
                      "to move the point.");
inline constexpr const char* kMeasure = QT_TRANSLATE_NOOP("studio", "Measure");
inline constexpr const char* kHintMeasure = QT_TRANSLATE_NOOP(
    "studio", "Click two points: on the surface, at curve ends, or on the drawing plane.");
inline constexpr const char* kDistance =
    QT_TRANSLATE_NOOP("studio", "Distance %1 %2\ndx %3, dy %4, dz %5");
inline constexpr const char* kSection = QT_TRANSLATE_NOOP("studio", "&Section plane");
inline constexpr const char* kPointAt = QT_TRANSLATE_NOOP(
    "studio", "%1, %2, %3. Start the drag with Shift to detach the point from other curves.");
inline constexpr const char* kAddProperty = QT_TRANSLATE_NOOP("studio", "Add property…");
inline constexpr const char* kHintSimulating = QT_TRANSLATE_NOOP(
    "studio", "The simulation runs: drag a slider. Stop it (T) before you push or fix points.");
inline constexpr const char* kHintCurveFromFile = QT_TRANSLATE_NOOP(
    "studio", "This curve is defined by a file or by parameters; its points cannot be edited.");
inline constexpr const char* kStopSimulationFirst =
    QT_TRANSLATE_NOOP("studio", "%1: stop the simulation first (T)");
// Titles of the colour scale.
inline constexpr const char* kDisplacementSinceRead =
    QT_TRANSLATE_NOOP("studio", "Displacement since the mesh was read");
inline constexpr const char* kDisplacementSinceOpened =
    QT_TRANSLATE_NOOP("studio", "Displacement since opened");
inline constexpr const char* kStrainSinceRead =
    QT_TRANSLATE_NOOP("studio", "Strain since the mesh was read");
inline constexpr const char* kStrainSinceOpened =
    QT_TRANSLATE_NOOP("studio", "Strain since opened");
inline constexpr const char* kCurvatureScale = QT_TRANSLATE_NOOP("studio", "Mean curvature");
inline constexpr const char* kStressScale = QT_TRANSLATE_NOOP("studio", "von Mises stress");
inline constexpr const char* kClipped = QT_TRANSLATE_NOOP("studio", "max %1 (scale clipped at %2)");
/// Unit of stresses in a scene with this length unit; empty: unknown.
inline QString stress_unit(const std::string& length) {
  return length == "m" ? "Pa" : length == "mm" ? "MPa" : "";
}
inline constexpr const char* kComputing = QT_TRANSLATE_NOOP("studio", "Computing stresses …");
inline constexpr const char* kInflate = QT_TRANSLATE_NOOP("studio", "Inflate");
inline constexpr const char* kInflateTip =
    QT_TRANSLATE_NOOP("studio", "Adds a shaping pressure on this face, with a slider");
inline constexpr const char* kPanels = QT_TRANSLATE_NOOP("studio", "Pa&nels");
inline constexpr const char* kSaved = QT_TRANSLATE_NOOP("studio", "Saved %1");
inline constexpr const char* kExported = QT_TRANSLATE_NOOP("studio", "Exported %1");
inline constexpr const char* kSceneRunDone = QT_TRANSLATE_NOOP("studio", "Wrote all outputs to %1");
inline constexpr const char* kOpenEnds = QT_TRANSLATE_NOOP(
    "studio", "No surface yet: %1 open curve ends. Draw curves that connect them.");
inline constexpr const char* kHintEmpty =
    QT_TRANSLATE_NOOP("studio", "Draw a curve (D), or open a scene, a curve file or a mesh.");
/// Filter of the input format. %1: name of the format, %2: extension.
inline constexpr const char* kOriginalFormat = QT_TRANSLATE_NOOP("studio", "%1, same cards (*%2)");
inline constexpr const char* kOriginalMesh =
    QT_TRANSLATE_NOOP("studio", "Format of the input (*%1)");
inline constexpr const char* kMeshFiles = QT_TRANSLATE_NOOP(
    "studio", "STL (*.stl);;OBJ (*.obj);;PLY (*.ply);;OFF (*.off);;ParaView (*.vtp);;glTF (*.glb)");
inline constexpr const char* kZoomToFit = QT_TRANSLATE_NOOP("studio", "&Zoom to fit");
inline constexpr const char* kFront = QT_TRANSLATE_NOOP("studio", "&Front");
inline constexpr const char* kSide = QT_TRANSLATE_NOOP("studio", "&Right");
inline constexpr const char* kTop = QT_TRANSLATE_NOOP("studio", "&Top");
inline constexpr const char* kIsometric = QT_TRANSLATE_NOOP("studio", "&Isometric");
inline constexpr const char* kPerspective = QT_TRANSLATE_NOOP("studio", "&Perspective");
inline constexpr const char* kMeshEdges = QT_TRANSLATE_NOOP("studio", "Mesh &edges");
inline constexpr const char* kCombs = QT_TRANSLATE_NOOP("studio", "Curvature &combs");
inline constexpr const char* kDarkTheme = QT_TRANSLATE_NOOP("studio", "&Dark theme");
inline constexpr const char* kShadings[] = {QT_TRANSLATE_NOOP("studio", "Shaded"),
                                            QT_TRANSLATE_NOOP("studio", "Faces"),
                                            QT_TRANSLATE_NOOP("studio", "Zebra"),
                                            QT_TRANSLATE_NOOP("studio", "Contour bands (z)"),
                                            QT_TRANSLATE_NOOP("studio", "Displacement"),
                                            QT_TRANSLATE_NOOP("studio", "Curvature"),
                                            QT_TRANSLATE_NOOP("studio", "Strain (max principal)"),
                                            QT_TRANSLATE_NOOP("studio", "Stress"),
                                            QT_TRANSLATE_NOOP("studio", "Mode shapes")};
inline constexpr const char* kPaintTip =
    QT_TRANSLATE_NOOP("studio", "Quantity that the brush paints");
/// Kinds of objects that the brush can create: label, and type in the scene.
inline constexpr std::pair<const char*, const char*> kPaints[] = {
    {QT_TRANSLATE_NOOP("studio", "Pressure"), "pressure"},
    {QT_TRANSLATE_NOOP("studio", "Bending stiffness β"), "beta"},
    {QT_TRANSLATE_NOOP("studio", "Membrane stiffness α"), "alpha"}};
inline constexpr const char* kModeOf = QT_TRANSLATE_NOOP("studio", "Mode %1: %2 Hz");
inline constexpr const char* kModeLegend =
    QT_TRANSLATE_NOOP("studio", "Mode %1: %2 Hz (amplitude scaled, slowed down)");
inline constexpr const char* kSimulate = QT_TRANSLATE_NOOP("studio", "Simulate (dynamic)");
inline constexpr const char* kSimulateTip = QT_TRANSLATE_NOOP(
    "studio", "Dynamic simulation with the settings of [motion]; sliders act on it (T)");
inline constexpr const char* kSimulating = QT_TRANSLATE_NOOP("studio", "simulating");
inline constexpr const char* kTour = QT_TRANSLATE_NOOP("studio", "Guided &tour");
inline constexpr const char* kTourNext = QT_TRANSLATE_NOOP("studio", "Next");
inline constexpr const char* kTourDone = QT_TRANSLATE_NOOP("studio", "Done");
inline constexpr const char* kTourClose = QT_TRANSLATE_NOOP("studio", "End tour");
inline constexpr const char* kTourStart = QT_TRANSLATE_NOOP(
    "studio",
    "This is a car door: five curves, and the surface with the least bending energy through them. "
    "Drag the background to orbit, turn the wheel to zoom, press <b>F</b> to zoom to fit.");
inline constexpr const char* kTourSlider = QT_TRANSLATE_NOOP(
    "studio", "Every parameter has a slider on the right. Drag <b>swell</b>, a pressure.");
inline constexpr const char* kTourPush =
    QT_TRANSLATE_NOOP("studio",
                      "Press <b>P</b> for the tool <b>Push</b>. Then press on the surface and "
                      "drag: the surface follows the pointer.");
inline constexpr const char* kTourZebra = QT_TRANSLATE_NOOP(
    "studio",
    "Is the surface fair? Select <b>Zebra</b> in the list of shadings above. Stripes that break: a "
    "crease (G0). Stripes that kink: a curvature jump (G1).");
inline constexpr const char* kTourStress = QT_TRANSLATE_NOOP(
    "studio", "The door is a steel sheet, too. Select <b>Stress</b> in the same list.");
inline constexpr const char* kTourUndo =
    QT_TRANSLATE_NOOP("studio", "<b>Ctrl+Z</b> undoes every action, one at a time. Try it.");
inline constexpr const char* kTourChoose =
    QT_TRANSLATE_NOOP("studio",
                      "Press <b>S</b> for <b>Select</b> and click a curve. The panel on the left "
                      "shows its properties and what you can do with it.");
inline constexpr const char* kTourEnd = QT_TRANSLATE_NOOP(
    "studio",
    "Now create your own model: <b>Ctrl+N</b> starts a scene, <b>D</b> draws curves. As soon as "
    "they close a loop, there is a surface. <b>Ctrl+E</b> exports it for CAD.");
inline constexpr const char* kAddPointForce = QT_TRANSLATE_NOOP("studio", "Add point force");
inline constexpr const char* kPlanes[] = {
    QT_TRANSLATE_NOOP("studio", "On XY plane"), QT_TRANSLATE_NOOP("studio", "On XZ plane"),
    QT_TRANSLATE_NOOP("studio", "On YZ plane"), QT_TRANSLATE_NOOP("studio", "On view plane")};

inline constexpr const char* kModel = QT_TRANSLATE_NOOP("studio", "Model");
inline constexpr const char* kSliders = QT_TRANSLATE_NOOP("studio", "Sliders");
inline constexpr const char* kProperties = QT_TRANSLATE_NOOP("studio", "Properties");
inline constexpr const char* kMessages = QT_TRANSLATE_NOOP("studio", "Messages");
inline constexpr const char* kCurves = QT_TRANSLATE_NOOP("studio", "Curves");
inline constexpr const char* kFaces = QT_TRANSLATE_NOOP("studio", "Faces");
inline constexpr const char* kEdges = QT_TRANSLATE_NOOP("studio", "Edges");
inline constexpr const char* kLoadsAndConstraints =
    QT_TRANSLATE_NOOP("studio", "Loads and constraints");
inline constexpr const char* kAlternatives = QT_TRANSLATE_NOOP("studio", "Alternative faces");
inline constexpr const char* kScene = QT_TRANSLATE_NOOP("studio", "Scene");
inline constexpr const char* kCrease = QT_TRANSLATE_NOOP("studio", "Crease (G0)");
inline constexpr const char* kSmooth = QT_TRANSLATE_NOOP("studio", "Smooth (G1)");
inline constexpr const char* kAngleOfNormals =
    QT_TRANSLATE_NOOP("studio", "%1: the surface normals differ by up to %2°");
inline constexpr const char* kRequested = QT_TRANSLATE_NOOP("studio", "%1 (requested)");
inline constexpr const char* kAutomatic = QT_TRANSLATE_NOOP("studio", "Automatic");
inline constexpr const char* kClampEdge = QT_TRANSLATE_NOOP("studio", "Clamp edge");
inline constexpr const char* kPinEdge = QT_TRANSLATE_NOOP("studio", "Pin edge");
inline constexpr const char* kPinEdgeTip =
    QT_TRANSLATE_NOOP("studio", "Simply supported: no displacement, free rotation");
inline constexpr const char* kRemoveSupport = QT_TRANSLATE_NOOP("studio", "Remove support");
inline constexpr const char* kAddPressure = QT_TRANSLATE_NOOP("studio", "Add pressure");
inline constexpr const char* kAddGravity = QT_TRANSLATE_NOOP("studio", "Add gravity");
inline constexpr const char* kStressLegend = QT_TRANSLATE_NOOP(
    "studio",
    "von Mises stress, load case '%3': max %1 %2\nmax displacement %4 %5 (deformation ×%6)");
inline constexpr const char* kSafety =
    QT_TRANSLATE_NOOP("studio", "\nSafety factor against yield: %1");
inline constexpr const char* kNoStress = QT_TRANSLATE_NOOP(
    "studio", "A stress analysis needs supports: select a curve, then clamp or pin that edge.");
inline constexpr const char* kFair = QT_TRANSLATE_NOOP("studio", "Fair curve");
inline constexpr const char* kFairLocally = QT_TRANSLATE_NOOP("studio", "Fair locally");
inline constexpr const char* kEditTangents = QT_TRANSLATE_NOOP("studio", "Edit end tangents");
inline constexpr const char* kSplit = QT_TRANSLATE_NOOP("studio", "Split at point");
inline constexpr const char* kJoinNext = QT_TRANSLATE_NOOP("studio", "Join with next");
inline constexpr const char* kJoinNextTip =
    QT_TRANSLATE_NOOP("studio", "Joins this curve with the curve that ends at the same point");
inline constexpr const char* kMirrors[] = {QT_TRANSLATE_NOOP("studio", "Mirror in YZ plane"),
                                           QT_TRANSLATE_NOOP("studio", "Mirror in XZ plane"),
                                           QT_TRANSLATE_NOOP("studio", "Mirror in XY plane")};
inline constexpr const char* kUseAlternative = QT_TRANSLATE_NOOP("studio", "Use this face");
inline constexpr const char* kHolesAndCreases = QT_TRANSLATE_NOOP("studio", "Holes and creases");
inline constexpr const char* kSelections = QT_TRANSLATE_NOOP("studio", "Sets and properties");
inline constexpr const char* kFeaturesAndConstraints =
    QT_TRANSLATE_NOOP("studio", "Features and constraints");
inline constexpr const char* kEdits = QT_TRANSLATE_NOOP("studio", "Edits");
inline constexpr const char* kPartUses[] = {QT_TRANSLATE_NOOP("studio", "Free"),
                                            QT_TRANSLATE_NOOP("studio", "Fixed"),
                                            QT_TRANSLATE_NOOP("studio", "Handle"),
                                            QT_TRANSLATE_NOOP("studio", "Rigid"),
                                            QT_TRANSLATE_NOOP("studio", "Rigid (no rotation)"),
                                            QT_TRANSLATE_NOOP("studio", "Region of interest")};
inline constexpr const char* kPartUseLabels[] = {QT_TRANSLATE_NOOP("studio", ""),
                                                 QT_TRANSLATE_NOOP("studio", "fixed"),
                                                 QT_TRANSLATE_NOOP("studio", "handle"),
                                                 QT_TRANSLATE_NOOP("studio", "rigid"),
                                                 QT_TRANSLATE_NOOP("studio", "rigid (no rotation)"),
                                                 QT_TRANSLATE_NOOP("studio", "region of interest")};
inline constexpr const char* kKeepAll = QT_TRANSLATE_NOOP("studio", "Keep all holes");
inline constexpr const char* kNewEdit = QT_TRANSLATE_NOOP("studio", "New edit");
inline constexpr const char* kFrames = QT_TRANSLATE_NOOP("studio", "Frames");
inline constexpr const char* kPlay = QT_TRANSLATE_NOOP("studio", "Play");
inline constexpr const char* kPreviousKey = QT_TRANSLATE_NOOP("studio", "◂ Previous key");
inline constexpr const char* kNextKey = QT_TRANSLATE_NOOP("studio", "Next key ▸");
inline constexpr const char* kFrameNumber = QT_TRANSLATE_NOOP("studio", "frame ");
inline constexpr const char* kKeyframes = QT_TRANSLATE_NOOP("studio", "Keyframes: %1");
inline constexpr const char* kOperations = QT_TRANSLATE_NOOP("studio", "Operations");
inline constexpr const char* kKey = QT_TRANSLATE_NOOP("studio", "Property");
inline constexpr const char* kValue = QT_TRANSLATE_NOOP("studio", "Value");
inline constexpr const char* kStop = QT_TRANSLATE_NOOP("studio", "Stop");
// Labels of sliders.
inline constexpr const char* kMembrane = QT_TRANSLATE_NOOP("studio", "Membrane stiffness α");
inline constexpr const char* kBending = QT_TRANSLATE_NOOP("studio", "Bending stiffness β");
/// %1: owner of the parameter, %2: parameter.
inline constexpr const char* kParameterOf = QT_TRANSLATE_NOOP("studio", "%1: %2");
inline constexpr const char* kRotationAngle = QT_TRANSLATE_NOOP("studio", "rotation");
inline constexpr const char* kNoSliders = QT_TRANSLATE_NOOP(
    "studio",
    "Each load, stiffness field and offset has a slider here. Push the surface to create a load.");
inline constexpr const char* kNoSlidersOfMesh =
    QT_TRANSLATE_NOOP("studio",
                      "The translation and rotation of each handle have sliders here. Select a "
                      "part and make it a handle.");
inline constexpr const char* kNoSlidersOfSequence = QT_TRANSLATE_NOOP(
    "studio", "Drag the arrows of a handle: the current frame becomes a keyframe.");
inline constexpr const char* kUnsaved = QT_TRANSLATE_NOOP("studio", "Save changes to %1?");
inline constexpr const char* kRecover = QT_TRANSLATE_NOOP(
    "studio", "batten-studio ended before the changes of %1 were saved. Restore them?");
inline constexpr const char* kUntitled = QT_TRANSLATE_NOOP("studio", "a new scene");
inline constexpr const char* kSceneFiles = QT_TRANSLATE_NOOP(
    "studio",
    "Scenes, curves and meshes (*.toml *.json *.csv *.txt *.xyz *.dat *.obj *.curves *.dxf *.svg "
    "*.iges *.igs *.step *.stp *.brep %1);;All files (*)");
inline constexpr const char* kSavedFiles = QT_TRANSLATE_NOOP("studio", "Scenes (*.toml)");
inline constexpr const char* kExportFiles = QT_TRANSLATE_NOOP(
    "studio",
    "STEP (*.step);;IGES (*.iges);;STL (*.stl);;OBJ (*.obj);;PLY (*.ply);;glTF (*.glb);;"
    "ParaView (*.vtp)");
inline constexpr const char* kScriptFiles = QT_TRANSLATE_NOOP("studio", "Scripts (*.batten)");
inline constexpr const char* kNoSurface = QT_TRANSLATE_NOOP("studio", "No surface yet");
inline constexpr const char* kUpdatesPerSecond = QT_TRANSLATE_NOOP("studio", "%1 updates/s");

}  // namespace batten::studio
