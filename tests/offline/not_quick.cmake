# Suites that take more than a CPU second. Chessboard and Formats (6 and 10 s) are quick tests all the same.
set(NOT_QUICK
  RunBundleAdjustment OptimizeWithLearnedPrior BlobCamera BoardGuess CanonicalFrame CameraInformation
  CaptureGuide Charuco SelectSamples MakeColmapFormat FeatureRefiner FitParametricModel FitRemapTable
  FrameQuality GuidedRig IdentifyBoard ImageCircle InterruptionsDeathTest AssessBudget
  LargeEquations Lenses/InitializeFromThreeViewsOf Lenses/UnevenLensOf LowContrast MarkerBoards
  NextView OutputFolder PackCamera PackSupportedSections AssignWithLayout PlainTagGrid PrintedFeatures
  EstimateProjectionUncertainty RegularRegion RenderImage ResidualBudget RigMotion LineDelay EstimatePopulationCovariance StackPacking
  StarDetector InitializeFromThreeViews MixedCameras TransformedImages VirtualView)
