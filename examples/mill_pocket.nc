%
(Pocket 100 x 60, 5 deep, end mill 20; origin at the lower left corner of the pocket, z 0 on top of the stock)
(Climb milling from the inside out, passes 4 apart, centre path with corner radius 5, last corners of the pocket 15)
G21 G17 G90 G94 G40 G61
T1 M6
S8000 M3
G0 X50 Y26 Z5
G1 Z-5 F300
F2400
(pass 1)
G1 X70
G3 X74 Y30 I0 J4
G3 X70 Y34 I-4 J0
G1 X30
G3 X26 Y30 I0 J-4
G3 X30 Y26 I4 J0
G1 X50
(link to the next pass)
G2 X52 Y24 R2
G3 X54 Y22 R2
(pass 2)
G1 X73
G3 X78 Y27 I0 J5
G1 Y33
G3 X73 Y38 I-5 J0
G1 X27
G3 X22 Y33 I0 J-5
G1 Y27
G3 X27 Y22 I5 J0
G1 X54
(link to the next pass)
G2 X56 Y20 R2
G3 X58 Y18 R2
(pass 3)
G1 X77
G3 X82 Y23 I0 J5
G1 Y37
G3 X77 Y42 I-5 J0
G1 X23
G3 X18 Y37 I0 J-5
G1 Y23
G3 X23 Y18 I5 J0
G1 X58
(link to the next pass)
G2 X60 Y16 R2
G3 X62 Y14 R2
(pass 4)
G1 X81
G3 X86 Y19 I0 J5
G1 Y41
G3 X81 Y46 I-5 J0
G1 X19
G3 X14 Y41 I0 J-5
G1 Y19
G3 X19 Y14 I5 J0
G1 X62
(link to the next pass)
G2 X64 Y12 R2
G3 X66 Y10 R2
(pass 5)
G1 X85
G3 X90 Y15 I0 J5
G1 Y45
G3 X85 Y50 I-5 J0
G1 X15
G3 X10 Y45 I0 J-5
G1 Y15
G3 X15 Y10 I5 J0
G1 X66
(leave the wall on an arc)
G3 X70 Y14 R4
G0 Z5
M5
M30
%
