# Suites that take more than a CPU second.
set(NOT_QUICK
  AdjustBundle AdjustModel AdjustWithLearnedPrior AutoModel BlobCamera BoardGuess Calibrate
  CalibrateBodies CalibrateRig CalibrateSameViews CalibrateTurnedBoards CameraFrame CameraFrames CameraKnowledge
  CaptureGuide Charuco ChooseKnots FeatureRefiner FitParametricModel FitRemapTable
  FrameQuality GuidedRig IdentifyBoard ImageCircle InterruptionsDeathTest JudgeBudget
  LargeEquations Lenses/StartFromThreeViewsOf Lenses/UnevenLensOf MarkerBoards
  NextView OutputFolder PackCamera PackWhatCanBe PlaceByLayout
  PrintedFeatures ProjectionUncertainty RenderImage ResidualBudget RowTime ShareOfBends
  SpreadAround StackPacking StarDetector StartFromThreeViews TrueErrors TwoCameras VirtualView)
