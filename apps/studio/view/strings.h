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
                      "Click a line or a surface to choose it. Drag points of a chosen line; a "
                      "double click adds one. "
                      "Drag beside to turn the view, wheel to zoom.");
inline constexpr const char* kHintPush = QT_TRANSLATE_NOOP(
    "studio",
    "Press on the surface and drag: it follows your hand. Drag beside it to turn the view.");
inline constexpr const char* kHintDraw = QT_TRANSLATE_NOOP(
    "studio", "Click points of a line; near the end of another line it snaps to that.");
inline constexpr const char* kHintDrawing = QT_TRANSLATE_NOOP(
    "studio",
    "Enter or a double click ends the line, Backspace takes a point back, Esc forgets it.");

inline constexpr const char* kHintSelectMesh =
    QT_TRANSLATE_NOOP("studio",
                      "Click an opening or a painted part, then say on the left what it is for. "
                      "Arrows and rings move "
                      "the handle.");
inline constexpr const char* kHintPaint = QT_TRANSLATE_NOOP(
    "studio", "Paint over nodes, with Shift to take some away. Drag beside the mesh to turn it.");
inline constexpr const char* kHintPath =
    QT_TRANSLATE_NOOP("studio",
                      "Draw the path that all frames are to follow, on the ground; Enter ends it. "
                      "Another one replaces "
                      "it.");
inline constexpr const char* kHintPaintArea =
    QT_TRANSLATE_NOOP("studio",
                      "Paint where the chosen load or weight acts, or a new one; with Shift to "
                      "take away. Its slider is "
                      "on the right.");
inline constexpr const char* kHintLasso = QT_TRANSLATE_NOOP(
    "studio",
    "Draw around nodes, with Shift to take some away. All that the line encloses counts, the back, "
    "too.");

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
inline constexpr const char* kExport = QT_TRANSLATE_NOOP("studio", "&Export the shape…");
inline constexpr const char* kRun = QT_TRANSLATE_NOOP("studio", "&Make all files of the scene…");
inline constexpr const char* kSaveScript =
    QT_TRANSLATE_NOOP("studio", "Save what was done as a s&cript…");
inline constexpr const char* kQuit = QT_TRANSLATE_NOOP("studio", "&Quit");
inline constexpr const char* kUndo = QT_TRANSLATE_NOOP("studio", "&Undo");
inline constexpr const char* kRedo = QT_TRANSLATE_NOOP("studio", "&Redo");
inline constexpr const char* kRemove = QT_TRANSLATE_NOOP("studio", "&Delete what is chosen");
inline constexpr const char* kSelect = QT_TRANSLATE_NOOP("studio", "Select");
inline constexpr const char* kPush = QT_TRANSLATE_NOOP("studio", "Push");
inline constexpr const char* kDraw = QT_TRANSLATE_NOOP("studio", "Draw a line");
inline constexpr const char* kPaint = QT_TRANSLATE_NOOP("studio", "Paint");
inline constexpr const char* kLasso = QT_TRANSLATE_NOOP("studio", "Lasso");
inline constexpr const char* kFixPoint = QT_TRANSLATE_NOOP("studio", "Hold");
inline constexpr const char* kHintFixPoint =
    QT_TRANSLATE_NOOP("studio",
                      "Click on the surface: it is held there, with Shift only its normal. Drag "
                      "the arrows to move the "
                      "place.");
inline constexpr const char* kMeasure = QT_TRANSLATE_NOOP("studio", "Measure");
inline constexpr const char* kHintMeasure = QT_TRANSLATE_NOOP(
    "studio", "Click two points: of the surface, ends of lines, or of the plane that you draw on.");
inline constexpr const char* kDistance =
    QT_TRANSLATE_NOOP("studio", "%1 %2\nalong x %3, y %4, z %5");
inline constexpr const char* kSection = QT_TRANSLATE_NOOP("studio", "&Section plane");
inline constexpr const char* kPointAt = QT_TRANSLATE_NOOP(
    "studio", "%1, %2, %3. Pressed with Shift, it leaves the lines that it meets.");
inline constexpr const char* kAddProperty = QT_TRANSLATE_NOOP("studio", "another key…");
inline constexpr const char* kHintSimulating = QT_TRANSLATE_NOOP(
    "studio", "It moves: drag a slider and see it swing. Let it rest (T) to push or hold.");
inline constexpr const char* kHintCurveFromFile = QT_TRANSLATE_NOOP(
    "studio", "This line is stated by a file or a shape: it has no points to drag.");
inline constexpr const char* kStopSimulationFirst =
    QT_TRANSLATE_NOOP("studio", "%1: let it rest first (T)");
inline constexpr const char* kSinceRead = QT_TRANSLATE_NOOP("studio", "since the mesh was read");
inline constexpr const char* kSinceOpened = QT_TRANSLATE_NOOP("studio", "since it was opened");
inline constexpr const char* kLargest = QT_TRANSLATE_NOOP("studio", "largest: %1");
inline constexpr const char* kComputing = QT_TRANSLATE_NOOP("studio", "Stress: …");
inline constexpr const char* kInflate = QT_TRANSLATE_NOOP("studio", "Swell");
inline constexpr const char* kPanels = QT_TRANSLATE_NOOP("studio", "&Panels");
inline constexpr const char* kSaved = QT_TRANSLATE_NOOP("studio", "Saved %1");
inline constexpr const char* kExported = QT_TRANSLATE_NOOP("studio", "Exported %1");
inline constexpr const char* kSceneRunDone = QT_TRANSLATE_NOOP("studio", "Made all files in %1");
inline constexpr const char* kOpenEnds = QT_TRANSLATE_NOOP(
    "studio", "No surface yet: %1 ends of lines are open. Draw on from one to the next.");
inline constexpr const char* kHintEmpty =
    QT_TRANSLATE_NOOP("studio", "Draw a line (D), or open a scene, lines or a mesh.");
inline constexpr const char* kOriginalFormat = QT_TRANSLATE_NOOP("studio", "As it was read (*%1)");
inline constexpr const char* kMeshFiles = QT_TRANSLATE_NOOP(
    "studio", "STL (*.stl);;OBJ (*.obj);;PLY (*.ply);;OFF (*.off);;ParaView (*.vtp);;glTF (*.glb)");
inline constexpr const char* kZoomToFit = QT_TRANSLATE_NOOP("studio", "Show &all");
inline constexpr const char* kFront = QT_TRANSLATE_NOOP("studio", "From the &front");
inline constexpr const char* kSide = QT_TRANSLATE_NOOP("studio", "From the &right");
inline constexpr const char* kTop = QT_TRANSLATE_NOOP("studio", "From a&bove");
inline constexpr const char* kIsometric = QT_TRANSLATE_NOOP("studio", "From a &corner");
inline constexpr const char* kPerspective = QT_TRANSLATE_NOOP("studio", "&Perspective");
inline constexpr const char* kMeshEdges = QT_TRANSLATE_NOOP("studio", "Facet &edges");
inline constexpr const char* kCombs = QT_TRANSLATE_NOOP("studio", "Curvature &combs");
inline constexpr const char* kDarkTheme = QT_TRANSLATE_NOOP("studio", "&Dark look");
inline constexpr const char* kShadings[] = {
    QT_TRANSLATE_NOOP("studio", "Plain"),    QT_TRANSLATE_NOOP("studio", "Regions"),
    QT_TRANSLATE_NOOP("studio", "Zebra"),    QT_TRANSLATE_NOOP("studio", "Heights"),
    QT_TRANSLATE_NOOP("studio", "Moved by"), QT_TRANSLATE_NOOP("studio", "Curvature"),
    QT_TRANSLATE_NOOP("studio", "Stretch"),  QT_TRANSLATE_NOOP("studio", "Stress"),
    QT_TRANSLATE_NOOP("studio", "Vibration")};
/// Kinds of objects that the brush can create: label, and type in the scene.
inline constexpr std::pair<const char*, const char*> kPaints[] = {
    {QT_TRANSLATE_NOOP("studio", "Paint pressure"), "pressure"},
    {QT_TRANSLATE_NOOP("studio", "Paint bending (beta)"), "beta"},
    {QT_TRANSLATE_NOOP("studio", "Paint stretching (alpha)"), "alpha"}};
inline constexpr const char* kModeOf = QT_TRANSLATE_NOOP("studio", "%1. %2 Hz");
inline constexpr const char* kModeLegend =
    QT_TRANSLATE_NOOP("studio", "Swings %1 times a second, drawn slower and larger");
inline constexpr const char* kSimulate = QT_TRANSLATE_NOOP("studio", "Let it move");
inline constexpr const char* kSimulateTip = QT_TRANSLATE_NOOP(
    "studio", "The surface swings and comes to rest as [motion] says; sliders act on it (T)");
inline constexpr const char* kSimulating = QT_TRANSLATE_NOOP("studio", "moving");
inline constexpr const char* kTour = QT_TRANSLATE_NOOP("studio", "&Tour of the door");
inline constexpr const char* kTourNext = QT_TRANSLATE_NOOP("studio", "Next");
inline constexpr const char* kTourDone = QT_TRANSLATE_NOOP("studio", "Done");
inline constexpr const char* kTourClose = QT_TRANSLATE_NOOP("studio", "End the tour");
inline constexpr const char* kTourStart =
    QT_TRANSLATE_NOOP("studio",
                      "This is a door: five lines, and the surface that bends as little as they "
                      "allow. Drag beside it to "
                      "turn the view, use the wheel to come nearer, F to see all.");
inline constexpr const char* kTourSlider = QT_TRANSLATE_NOOP(
    "studio", "Every number that may move has a slider on the right. Drag <b>swell</b>.");
inline constexpr const char* kTourPush =
    QT_TRANSLATE_NOOP("studio",
                      "Press <b>P</b> for the tool <b>Push</b>. Then press on the surface and "
                      "drag: it follows your hand.");
inline constexpr const char* kTourZebra =
    QT_TRANSLATE_NOOP("studio",
                      "Is it fair? Choose <b>Zebra</b> in the list of shadings above: stripes that "
                      "break are creases.");
inline constexpr const char* kTourStress =
    QT_TRANSLATE_NOOP("studio", "It is a steel sheet, too. Choose <b>Stress</b> in the same list.");
inline constexpr const char* kTourUndo =
    QT_TRANSLATE_NOOP("studio", "<b>Ctrl+Z</b> takes everything back, step by step. Try it.");
inline constexpr const char* kTourChoose =
    QT_TRANSLATE_NOOP("studio",
                      "Press <b>S</b> for <b>Select</b> and click a line: on the left is what the "
                      "scene says of it, and "
                      "what can be done with it.");
inline constexpr const char* kTourEnd =
    QT_TRANSLATE_NOOP("studio",
                      "Now your own: <b>Ctrl+N</b> begins a scene, <b>D</b> draws lines, and as "
                      "soon as they close there "
                      "is a surface. Ctrl+E exports it for CAD.");
inline constexpr const char* kAddPointForce = QT_TRANSLATE_NOOP("studio", "Load: force here");
inline constexpr const char* kPlanes[] = {QT_TRANSLATE_NOOP("studio", "Draw on the ground (xy)"),
                                          QT_TRANSLATE_NOOP("studio", "Draw upright (xz)"),
                                          QT_TRANSLATE_NOOP("studio", "Draw upright (yz)"),
                                          QT_TRANSLATE_NOOP("studio", "Draw facing me")};

inline constexpr const char* kModel = QT_TRANSLATE_NOOP("studio", "Model");
inline constexpr const char* kSliders = QT_TRANSLATE_NOOP("studio", "Sliders");
inline constexpr const char* kProperties = QT_TRANSLATE_NOOP("studio", "What is chosen");
inline constexpr const char* kMessages = QT_TRANSLATE_NOOP("studio", "Messages");
inline constexpr const char* kLines = QT_TRANSLATE_NOOP("studio", "Lines");
inline constexpr const char* kRegions = QT_TRANSLATE_NOOP("studio", "Surfaces");
inline constexpr const char* kJoins = QT_TRANSLATE_NOOP("studio", "Joins");
inline constexpr const char* kLoadsAndConstraints = QT_TRANSLATE_NOOP("studio", "What acts");
inline constexpr const char* kAlternatives = QT_TRANSLATE_NOOP("studio", "Close choices");
inline constexpr const char* kScene = QT_TRANSLATE_NOOP("studio", "Scene");
inline constexpr const char* kCrease = QT_TRANSLATE_NOOP("studio", "Crease");
inline constexpr const char* kSmooth = QT_TRANSLATE_NOOP("studio", "Smooth");
inline constexpr const char* kAutomatic = QT_TRANSLATE_NOOP("studio", "As found");
inline constexpr const char* kClampEdge = QT_TRANSLATE_NOOP("studio", "Clamp it");
inline constexpr const char* kPinEdge = QT_TRANSLATE_NOOP("studio", "Pin it");
inline constexpr const char* kRemoveSupport = QT_TRANSLATE_NOOP("studio", "No support");
inline constexpr const char* kAddPressure = QT_TRANSLATE_NOOP("studio", "Load: pressure");
inline constexpr const char* kAddGravity = QT_TRANSLATE_NOOP("studio", "Load: its weight");
inline constexpr const char* kStressLegend = QT_TRANSLATE_NOOP(
    "studio", "Stress: %1 %2 at most, case '%3'\nmoves by %4 %5, drawn %6 times larger");
inline constexpr const char* kSafety = QT_TRANSLATE_NOOP("studio", "\nyields at %1 times the load");
inline constexpr const char* kNoStress =
    QT_TRANSLATE_NOOP("studio", "Stresses need supports: choose a line, and clamp or pin it.");
inline constexpr const char* kFair = QT_TRANSLATE_NOOP("studio", "Fair it");
inline constexpr const char* kFairLocally = QT_TRANSLATE_NOOP("studio", "Fair at point");
inline constexpr const char* kEditTangents = QT_TRANSLATE_NOOP("studio", "Tangents by hand");
inline constexpr const char* kSplit = QT_TRANSLATE_NOOP("studio", "Split at point");
inline constexpr const char* kJoinNext = QT_TRANSLATE_NOOP("studio", "Join neighbour");
inline constexpr const char* kMirrors[] = {QT_TRANSLATE_NOOP("studio", "Mirror x"),
                                           QT_TRANSLATE_NOOP("studio", "Mirror y"),
                                           QT_TRANSLATE_NOOP("studio", "Mirror z")};
inline constexpr const char* kUseAlternative = QT_TRANSLATE_NOOP("studio", "Take this instead");
inline constexpr const char* kHolesAndCreases = QT_TRANSLATE_NOOP("studio", "Openings and creases");
inline constexpr const char* kSelections = QT_TRANSLATE_NOOP("studio", "Selections and sets");
inline constexpr const char* kFeaturesAndConstraints = QT_TRANSLATE_NOOP("studio", "What is kept");
inline constexpr const char* kEdits = QT_TRANSLATE_NOOP("studio", "Edits");
inline constexpr const char* kPartUses[] = {
    QT_TRANSLATE_NOOP("studio", "Let go"),         QT_TRANSLATE_NOOP("studio", "Fixed"),
    QT_TRANSLATE_NOOP("studio", "Handle"),         QT_TRANSLATE_NOOP("studio", "Rigid"),
    QT_TRANSLATE_NOOP("studio", "Rigid, no turn"), QT_TRANSLATE_NOOP("studio", "Only this moves")};
inline constexpr const char* kPartUseLabels[] = {QT_TRANSLATE_NOOP("studio", ""),
                                                 QT_TRANSLATE_NOOP("studio", "fixed"),
                                                 QT_TRANSLATE_NOOP("studio", "handle"),
                                                 QT_TRANSLATE_NOOP("studio", "rigid"),
                                                 QT_TRANSLATE_NOOP("studio", "rigid, no turn"),
                                                 QT_TRANSLATE_NOOP("studio", "region of interest")};
inline constexpr const char* kKeepAll = QT_TRANSLATE_NOOP("studio", "Keep all openings");
inline constexpr const char* kNewEdit = QT_TRANSLATE_NOOP("studio", "Go on with a new edit");
inline constexpr const char* kFrames = QT_TRANSLATE_NOOP("studio", "Frames");
inline constexpr const char* kPlay = QT_TRANSLATE_NOOP("studio", "Play");
inline constexpr const char* kPreviousKey = QT_TRANSLATE_NOOP("studio", "◂ key");
inline constexpr const char* kNextKey = QT_TRANSLATE_NOOP("studio", "key ▸");
inline constexpr const char* kKeyframes = QT_TRANSLATE_NOOP("studio", "keyframes: %1");
inline constexpr const char* kSequenceSteps = QT_TRANSLATE_NOOP("studio", "Steps");
inline constexpr const char* kKey = QT_TRANSLATE_NOOP("studio", "Key");
inline constexpr const char* kValue = QT_TRANSLATE_NOOP("studio", "Value");
inline constexpr const char* kStop = QT_TRANSLATE_NOOP("studio", "Stop");
inline constexpr const char* kNoSliders = QT_TRANSLATE_NOOP(
    "studio", "Loads, weights and moves have a slider each. Push the surface to make one.");
inline constexpr const char* kNoSlidersOfMesh = QT_TRANSLATE_NOOP(
    "studio", "The moves of handles have a slider each. Choose a part and make it a handle.");
inline constexpr const char* kNoSlidersOfSequence = QT_TRANSLATE_NOOP(
    "studio", "Drag the arrows of a handle: the frame that is shown becomes a keyframe.");
inline constexpr const char* kUnsaved =
    QT_TRANSLATE_NOOP("studio", "%1 has changes that are not saved.");
inline constexpr const char* kRecover = QT_TRANSLATE_NOOP(
    "studio", "Changes of %1 were not saved when the program ended. Take them up again?");
inline constexpr const char* kUntitled = QT_TRANSLATE_NOOP("studio", "a new scene");
inline constexpr const char* kSceneFiles = QT_TRANSLATE_NOOP(
    "studio",
    "Scenes, lines and meshes (*.toml *.json *.csv *.txt *.xyz *.dat *.obj *.curves *.dxf *.svg "
    "*.iges *.igs *.step *.stp *.brep *.off *.ply *.stl *.vtp *.vtu *.bdf *.nas *.inp *.k *.key "
    "*.dyn "
    "*.rad);;All files (*)");
inline constexpr const char* kSavedFiles = QT_TRANSLATE_NOOP("studio", "Scenes (*.toml)");
inline constexpr const char* kExportFiles = QT_TRANSLATE_NOOP(
    "studio",
    "STEP (*.step);;IGES (*.iges);;STL (*.stl);;OBJ (*.obj);;PLY (*.ply);;glTF (*.glb);;"
    "ParaView (*.vtp)");
inline constexpr const char* kScriptFiles = QT_TRANSLATE_NOOP("studio", "Scripts (*.batten)");
inline constexpr const char* kNoSurface = QT_TRANSLATE_NOOP("studio", "No surface yet");
inline constexpr const char* kUpdatesPerSecond = QT_TRANSLATE_NOOP("studio", "%1 answers a second");

}  // namespace batten::studio
