# Suites that take more than a CPU second. Chessboard and Formats (6 and 10 s) are quick tests all the same.
set(NOT_QUICK
  AdjustBundle AdjustWithLearnedPrior BlobCamera BoardGuess CameraFrame CameraKnowledge
  CaptureGuide Charuco ChooseKnots ColmapFormat FeatureRefiner FitParametricModel FitRemapTable
  FrameQuality GuidedRig IdentifyBoard ImageCircle InterruptionsDeathTest JudgeBudget
  LargeEquations Lenses/StartFromThreeViewsOf Lenses/UnevenLensOf LowContrast MarkerBoards
  NextView OutputFolder PackCamera PackWhatCanBe PlaceByLayout PlainTagGrid PrintedFeatures
  ProjectionUncertainty RegularRegion RenderImage ResidualBudget RowTime SpreadAround StackPacking
  StarDetector StartFromThreeViews TwoCameras VirtualView)
