# Which tests of offline/ run when. RAYGRID_LONG_TESTS (tests/run everything) runs all.

# With sanitizers these take minutes: what they reach, others reach on less data.
set(RAYGRID_SLOW_WITH_SANITIZERS
  BoardAppearance.LayersPaint*
  CameraFrame.DoesNotDepend*
  Chessboard.EveryCorner*
  FeatureRefiner.IsMoreAccurate*
  FitDistortionTable.Undoes*
  FitRemapTable.KeepsTheBound*
  IdentifyBoard.NamesNoBoardOfAnother*
  IdentifyBoard.TakesNoOther*
  ImageCircle.IsFoundWhereverItLies*
  ImageCircle.IsNotFoundWhere*
  LensChoice.Compares*
  LensChoice.Counts*
  LensChoice.Measures*
  LensChoice.TakesTheFewest*
  LensModels.FitACamera*
  MarkerBoards.AreToldApart*
  OutputFolder.Kills*
  PackCamera.CamerasWithoutRays*
  PackCamera.RoughCameras*
  AssignByLayout.IsNeverWrong*
  PrintedInk.OfAprilGrids*
  PrintedInk.OfCharuco*
  PrintedInk.OfSix*
  StarDetector.FindsNearlyAll*
  StarDetector.FindsStarsIn*
  StarDetector.FindsStarsOfABoardWhoseTagIsCutOff*
  StarDetector.FindsStarsOfAny*
  StarDetector.FindsTheSame*
  StarDetector.Is*
  StarDetector.NamesBoardsOfBent*
  StarDetector.Refines*
  VirtualView.OfA*)

set(RAYGRID_LEFT_OUT_TESTS)
if(NOT RAYGRID_LONG_TESTS AND CMAKE_BUILD_TYPE STREQUAL "Sanitized")
  set(RAYGRID_LEFT_OUT_TESTS ${RAYGRID_SLOW_WITH_SANITIZERS})
endif()
